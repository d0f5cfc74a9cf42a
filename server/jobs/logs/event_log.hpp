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

/// The file has nothing of an event log of this version.
class NoEventLog : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// The append-only file of a job's events; its format stands in EVENT_LOG.md. Safe to use from
/// several threads: one appends, any number read.
///
/// At any time one process appends: the worker from the start of its run to its end, else the
/// daemon. The other one reads what is there, see refresh().
class EventLog {
public:
  /// Where a reader stands: the next event it has not seen.
  struct Cursor {
    std::int64_t sequence = 1;
    std::int64_t offset = 0;  ///< of its record in the file; 0: not known yet
  };

  /// Reads what is there and changes nothing. Damage is reported in the program's log, and readers
  /// get a warning in the place of each event that is lost.
  /// @throws std::system_error  the file cannot be read
  /// @throws NoEventLog         neither its header nor any record is sound
  explicit EventLog(const std::filesystem::path& path);
  ~EventLog();  ///< syncs the rest to disk; a failure is logged

  /// Makes this process the one that appends: takes what the other one has written, cuts off a torn
  /// tail, puts a damaged header right. append() does it where it was not done. Once more after a
  /// failed sync() it writes again what that left in doubt, and the log accepts events again.
  /// @throws std::system_error  the file cannot be written
  void take_over();
  /// From now on another process appends.
  void hand_over();
  /// Takes what another process has appended. @return whether there is anything new
  bool refresh();

  /// Appends an event and gives it its sequence and, unless it has one, its time.
  /// @throws std::system_error   disk full or not writable, now or at the last sync(); the log is
  ///                             as it was
  /// @throws std::logic_error    the log has ended
  void append(v1::JobEvent& event);

  /// Appends an event that no reader sees before announce(); the next append() announces it too.
  /// There is one at a time: a second call does nothing. @throws as append()
  void prepare(v1::JobEvent& event);
  void announce();

  /// Syncs what was appended to disk; cheap when nothing was. @throws std::system_error
  void sync() { log_.sync(); }

  /// The event under the cursor, which moves on. @return nothing when there is none yet
  /// @throws std::runtime_error  the file was damaged after it was opened
  std::optional<v1::JobEvent> read(Cursor& cursor) const;

  /// Number of the last event; 0 in an empty log.
  std::int64_t last_sequence() const;
  /// The terminal event, once there is one.
  std::optional<v1::JobEvent> terminal_event() const;
  /// Whether an event says nothing new: a finding as the last one of its code, a second loss of
  /// validity.
  bool knows(const v1::JobEvent& event) const;
  /// Brings a job up to what the log has of it beside its state: last step, findings, loss of
  /// validity.
  void complete(v1::Job& job) const;
  /// What the log holds, without its events.
  EventLogContent content() const;
  /// Called after every append and refresh() with something new, outside of any lock of the log.
  /// Set once, before the log is shared.
  void on_append(std::function<void()> call) { on_append_ = std::move(call); }

private:
  const std::filesystem::path& path() const { return log_.file().path(); }
  bool appends() const;
  void repair();
  void cut_tail();
  std::int64_t record_size(std::int64_t offset) const;
  std::optional<std::string> payload_at(std::int64_t offset, std::int64_t end) const;
  void locate(Cursor& cursor) const;

  storage::RecordLog log_;
  std::function<void()> on_append_;
  mutable std::mutex mutex_;
  EventLogContent content_;
  bool appends_ = false;   ///< this process does
  bool prepared_ = false;  ///< a record behind the last one of `content_` waits for announce()
};

}  // namespace dccast::jobs
