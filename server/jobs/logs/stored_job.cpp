#include "server/jobs/logs/stored_job.hpp"

#include <fmt/core.h>

#include "core/storage/file.hpp"
#include "server/jobs/logs/event_log_scan.hpp"

namespace dccast::jobs {

namespace {

namespace fs = std::filesystem;

/// Size of a submission, as make_record() counts it [bytes].
std::int64_t submission_bytes(const fs::path& folder, const JobDescription& description) {
  auto bytes = description.submitted_case.size() + description.complete_case.size();
  if (fs::exists(folder / submitted_file)) bytes += fs::file_size(folder / submitted_file);
  if (fs::exists(folder / attachments_folder))
    for (const auto& file : fs::directory_iterator(folder / attachments_folder))
      bytes += file.file_size();
  return static_cast<std::int64_t>(bytes);
}

/// Scans the event log; anything but a regular file counts as empty.
EventLogContent scan_log(const fs::path& folder) {
  const fs::path log = folder / "events.log";
  const bool is_file = storage::kind_of_entry(log) == storage::regular_file;
  return is_file ? scan_event_log(log) : EventLogContent{};
}

/// A lost log can be begun again only if no other file shows that the job has run.
/// @throws std::runtime_error  another file does
void require_no_lost_history(const fs::path& folder) {
  if (fs::exists(folder / "results.h5"))
    throw std::runtime_error("its events.log is lost, and it has results of an unknown attempt");
  if (!storage::kind_of_entry(folder / "events.log").empty() && fs::exists(folder / "worker.log"))
    throw std::runtime_error("its events.log has no event that can be read, and it has run");
}

/// Sets state, attempts, times, failure and artifacts of a record from its event log.
void apply(const EventLogContent& content, const fs::path& folder, JobRecord& record) {
  v1::Job& job = record.job;
  job.set_attempts(content.attempts);
  if (content.started) *job.mutable_start_time() = *content.started;
  content.complete(job);
  if (!content.last_state) return;

  const v1::JobEvent::StateChange& change = *content.last_state;
  job.set_state(change.state());
  record.losses = change.losses();
  record.solver = change.solver();
  record.sequence = content.state_sequence;
  if (!change.terminal()) return;

  if (content.terminal) *job.mutable_end_time() = content.terminal->time();
  if (change.has_failure()) *job.mutable_failure() = change.failure();
  *job.mutable_artifacts() = change.artifacts();
  record.bytes = bytes_kept(folder);
}

}  // namespace

JobRecord described_job(const fs::path& folder) {
  const JobDescription description = read_job_description(folder);
  if (description.job.id() != folder.filename())
    throw std::runtime_error(fmt::format("it describes another job, {}", description.job.id()));

  JobRecord record;
  record.job = description.job;
  record.job.set_state(v1::QUEUED);
  read_marks(folder, record.job);
  record.answer_key = description.answer_key;
  record.bytes = submission_bytes(folder, description);
  return record;
}

JobRecord read_job(const fs::path& folder) {
  JobRecord record = described_job(folder);
  const EventLogContent content = scan_log(folder);
  if (content.last_sequence == 0)
    require_no_lost_history(folder);
  else
    apply(content, folder, record);
  return record;
}

bool agrees(const JobRecord& row, const JobRecord& stored) {
  // A run reports on after its row was written, and the time that it took stands in the row alone.
  const auto without_reports = [](v1::Job job) {
    job.clear_run_s();
    job.clear_last_step();
    job.clear_findings();
    job.clear_validity_loss();
    return job.SerializeAsString();
  };
  return without_reports(row.job) == without_reports(stored.job);
}

std::int64_t last_state_sequence(const fs::path& folder) {
  return scan_log(folder).state_sequence;
}

}  // namespace dccast::jobs
