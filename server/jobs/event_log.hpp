#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/storage/record_log.hpp"
#include "dccast/v1/job.pb.h"
#include "server/jobs/event_log_scan.hpp"

namespace dccast::jobs {

/// The append-only file of a job's events; its format stands in EVENT_LOG.md. Safe to use from
/// several threads: one appends, any number read.
class EventLog {
public:
  /// Where a reader stands: the next event it has not seen.
  struct Cursor {
    std::int64_t sequence = 1;
    std::int64_t offset = 0;  ///< of its record in the file; 0: not known yet
  };

  /// Opens the log or begins one; cuts off a torn tail. Damage in the middle stays in the file, is
  /// said in the program's log, and readers get a warning in the place of each event that is lost.
  /// @throws std::system_error   the file cannot be read or written
  /// @throws std::runtime_error  it is not an event log of this version
  explicit EventLog(const std::filesystem::path& path);
  ~EventLog();  ///< syncs the rest to disk; a failure is logged

  /// Appends an event and gives it its sequence and, unless it has one, its time.
  /// @throws std::system_error   disk full or not writable, now or at the last sync(); the log is
  ///                             as it was
  /// @throws std::logic_error    the log has ended
  void append(v1::JobEvent& event);

  /// Syncs what was appended to disk; cheap when nothing was. @throws std::system_error
  void sync() { log_.sync(); }

  /// The event under the cursor, which moves on. @return nothing when there is none yet
  /// @throws std::runtime_error  the file was damaged after it was opened
  std::optional<v1::JobEvent> read(Cursor& cursor) const;

  /// Number of the last event; 0 in an empty log.
  std::int64_t last_sequence() const;
  /// The terminal event, once there is one.
  std::optional<v1::JobEvent> terminal_event() const;
  /// The last step reported and not taken back by a resumption, if there is one.
  std::optional<v1::StepReport> last_step() const;
  /// Whether the last finding of its code is the same.
  bool has(const v1::Finding& finding) const;
  /// Whether the model has stopped being valid.
  bool has_validity_loss() const;
  /// Brings a job up to what the log tells of it beside its state: last step, findings, loss of
  /// validity.
  void tell(v1::Job& job) const;
  /// The step up to which the history goes: that of the last report or resumption; 0 at first.
  std::int64_t reached_step() const;
  /// How many reports of the present attempt's worker there are, see is_report(); nothing when
  /// damage to the file has left that open.
  std::optional<std::int64_t> attempt_reports() const;
  /// The state of the last state change, if there is one.
  std::optional<v1::JobState> last_state() const;

  /// What is damaged, with sound events behind it; fixed when the log is opened.
  std::vector<EventGap> gaps() const;

  /// Called after every append, outside of any lock of the log. Set once, before the log is shared.
  void on_append(std::function<void()> call) { on_append_ = std::move(call); }

private:
  const std::filesystem::path& path() const { return log_.file().path(); }
  void cut_tail();
  std::optional<std::string> payload_at(std::int64_t offset, std::int64_t end) const;
  void locate(Cursor& cursor) const;
  v1::JobEvent lost_event(Cursor& cursor, const EventGap& gap) const;

  storage::RecordLog log_;
  std::function<void()> on_append_;
  mutable std::mutex mutex_;
  EventLogContent content_;
};

}  // namespace dccast::jobs
