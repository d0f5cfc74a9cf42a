#include "server/jobs/queue/submissions.hpp"

#include <fmt/format.h>

#include <system_error>
#include <utility>

#include "core/storage/file.hpp"
#include "proto/refusal/refusal.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/logs/readings_log.hpp"

namespace dccast::jobs {

namespace {

/// A repeated request must name the same case, and the same study.
void require_same_submission(const v1::Job& existing, const v1::Job& job) {
  const bool same_case = existing.case_sha256() == job.case_sha256();
  if (same_case && existing.study() == job.study()) return;
  throw RequestIdTaken(fmt::format("request_id \"{}\" was used for another {} (job {})",
                                   job.request_id(), same_case ? "study" : "case", existing.id()));
}

/// Counts a submission as a waiting job from the first check of the queue to its place in it.
class Reservation {
public:
  Reservation(std::mutex& mutex, int& count) : mutex_(mutex), count_(count) { ++count_; }
  Reservation(const Reservation&) = delete;
  ~Reservation() {
    const std::lock_guard lock(mutex_);
    --count_;
  }

private:
  std::mutex& mutex_;
  int& count_;
};

/// Removes folder and row of a job that was not accepted. The caller reports the cause; the next
/// recovery removes remaining files.
void discard(JobStore& store, const std::filesystem::path& folder) {
  std::error_code ignored;
  std::filesystem::remove_all(folder, ignored);
  try {
    store.erase(folder.filename());
  } catch (const StoreError& error) {
    log::warn("{}", error.what());
  }
}

}  // namespace

v1::Job Submissions::submit(const NewJob& new_job, const Attachments& attachments) {
  // A repeated request returns the job of the first one.
  const v1::Job& submitted = new_job.description.job;
  if (!submitted.request_id().empty()) {
    if (const auto existing = state_.store.find_request(submitted.request_id())) {
      require_same_submission(existing->job, submitted);
      return current(existing->job);
    }
  }

  JobRecord record = make_record(new_job, attachments);
  require_room(record.bytes);
  std::optional<Reservation> reservation;
  {
    const std::lock_guard lock(state_.mutex);
    if (state_.shutting_down) throw ShuttingDown("dccastd is shutting down");
    if (state_.waiting() + under_way_ >= state_.options.maximum_queued)
      throw refusal::LimitReached({.cause = "the queue is full",
                                   .limit = "limits.maximum_queued",
                                   .permitted = std::to_string(state_.options.maximum_queued),
                                   .remedy = "submit again later"});
    reservation.emplace(state_.mutex, under_way_);
  }

  if (const auto existing = write_new_job(record, new_job, attachments)) {
    require_same_submission(*existing, submitted);
    return current(*existing);
  }
  log::info("job {}: QUEUED: submitted{}", record.job.id(),
            record.job.title().empty() ? "" : fmt::format(" as \"{}\"", record.job.title()));

  const Lane lane = new_job.following    ? Lane::followed
                    : new_job.goes_first ? Lane::query
                                         : Lane::job;
  const std::lock_guard lock(state_.mutex);
  state_.enqueue(record.job, lane);
  state_.changed.notify_all();
  return views_.view(std::move(record));
}

/// The present state of an existing job.
v1::Job Submissions::current(const v1::Job& job) {
  auto record = state_.ledger.find(job.id());
  if (!record) return job;
  const std::lock_guard lock(state_.mutex);
  return views_.view(std::move(*record));
}

void Submissions::require_room(std::int64_t bytes) {
  require_free_space(state_.jobs_directory, state_.options.minimum_free_bytes);
  std::string held;
  {
    const std::lock_guard lock(state_.mutex);
    held = state_.queue_hold.reason();
  }
  if (!held.empty())
    throw StorageHeld(fmt::format("the queue is held and takes no job now: {}", held));

  const std::int64_t waiting = state_.store.unfinished_bytes();
  if (waiting + bytes > state_.options.maximum_waiting_bytes)
    throw refusal::LimitReached(
        {.cause = fmt::format("cases and attachments of the jobs that have not ended take {} "
                              "bytes, this one {}",
                              waiting, bytes),
         .limit = "limits.maximum_waiting",
         .permitted = fmt::format("{} bytes", state_.options.maximum_waiting_bytes),
         .remedy = "submit again when some have ended"});
}

/// Writes a new job to disk: folder, event log, row, mark. @return the existing job if a concurrent
/// submission has used the same request_id; nothing of the new job remains then
std::optional<v1::Job> Submissions::write_new_job(JobRecord& record, const NewJob& new_job,
                                                  const Attachments& attachments) {
  const auto folder = state_.jobs_directory / record.job.id();
  JobDescription description = new_job.description;
  description.job = record.job;
  if (new_job.following) description.files.push_back(readings_file);
  create_job_folder(folder, attachments, description, new_job.case_file);
  try {
    const auto log = state_.logs.open(record.job.id());
    v1::JobEvent event = state_event(record, "submitted");
    log->append(event);
    log->sync();
    record.sequence = event.sequence();
    if (new_job.following) create_readings_log(folder, *new_job.following);

    const auto existing = state_.store.insert(record);
    if (!existing) {
      mark_accepted(folder);
      return std::nullopt;
    }
    discard(state_.store, folder);
    return existing->job;
  } catch (...) {
    discard(state_.store, folder);
    throw;
  }
}

}  // namespace dccast::jobs
