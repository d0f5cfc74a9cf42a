#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>

#include "core/storage/record_log.hpp"
#include "dccast/v1/job.pb.h"
#include "server/jobs/logs/event_log_scan.hpp"

namespace dccast::jobs {

/// The file holds neither a header nor a record of an event log of this version.
class NoEventLog : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// The append-only file of a job's events; EVENT_LOG.md describes its format. Safe to use from
/// several threads: one appends, any number read.
///
/// Only one process appends at any time: the worker during its run, else the daemon. The other
/// process reads the file, see refresh().
class EventLog {
public:
  /// Position of a reader: the next event it has not read.
  struct Cursor {
    std::int64_t sequence = 1;
    std::int64_t offset = 0;  ///< of its record in the file [bytes]; 0: not known yet
  };

  /// Scans the file without changing it. Damage is reported in the program's log, and readers
  /// receive a warning in place of each lost event.
  /// @throws std::system_error  the file cannot be read
  /// @throws NoEventLog         neither its header nor any record is sound
  explicit EventLog(const std::filesystem::path& path);
  ~EventLog();  ///< syncs the rest to disk; a failure is logged

  /// Makes this process the one that appends: reads what the other one has written, cuts off a torn
  /// tail, repairs a damaged header. append() calls it if necessary. After a failed sync() it
  /// writes the records in doubt again, and the log accepts events again.
  /// @throws std::system_error  the file cannot be written
  void take_over();
  /// Leaves the log to another process, which appends from now on.
  void hand_over();
  /// Reads what another process has appended. @return whether there was anything new
  bool refresh();

  /// Appends an event and gives it its sequence and, unless it has one, its time.
  /// @throws std::system_error   disk full or not writable, now or at the last sync(); the log is
  ///                             unchanged
  /// @throws std::logic_error    the log has ended
  void append(v1::JobEvent& event);

  /// Appends an event that no reader sees before announce(); the next append() announces it too.
  /// Only one event can be prepared: a second call does nothing. @throws as append()
  void prepare(v1::JobEvent& event);
  /// Shows watchers what has been appended.
  void announce();

  /// Syncs appended events to disk; cheap if there are none. @throws std::system_error
  void sync() { log_.sync(); }

  /// Reads the event at the cursor and advances it. @return nothing if there is none yet
  /// @throws std::runtime_error  the file was damaged after it was opened
  std::optional<v1::JobEvent> read(Cursor& cursor) const;

  /// Sequence number of the last event; 0 in an empty log.
  std::int64_t last_sequence() const;
  /// The terminal event, once there is one.
  std::optional<v1::JobEvent> terminal_event() const;
  /// Whether an event adds nothing: a finding equal to the last one of its code, or a second loss
  /// of validity.
  bool knows(const v1::JobEvent& event) const;
  /// See EventLogContent::complete().
  void complete(v1::Job& job) const;
  /// Summary of the log, without its events.
  EventLogContent content() const;
  /// Sets a function to call after every append, and after every refresh() that has read something.
  /// The call holds no lock of the log.
  /// Set once, before the log is shared.
  void on_append(std::function<void()> call) { on_append_ = std::move(call); }

private:
  const std::filesystem::path& path() const { return log_.file().path(); }
  /// Whether this process may append: the worker does, while it runs.
  bool appends() const;
  /// Restores a log whose header or end is damaged.
  void repair();
  /// Cuts off what follows the last sound record; a whole but damaged record is kept in a file.
  void cut_tail();
  /// Size of the record at an offset, with its head [bytes]; 0 if there is no whole head.
  std::int64_t record_size(std::int64_t offset) const;
  /// Content of the record at an offset; empty if it is damaged. @param end  offset behind it
  std::optional<std::string> payload_at(std::int64_t offset, std::int64_t end) const;
  /// Moves a cursor to its sequence number.
  void locate(Cursor& cursor) const;

  storage::RecordLog log_;
  std::function<void()> on_append_;
  mutable std::mutex mutex_;
  EventLogContent content_;
  bool appends_ = false;   ///< this process is the one that appends
  bool prepared_ = false;  ///< a record after the last one of `content_` waits for announce()
};

}  // namespace dccast::jobs
