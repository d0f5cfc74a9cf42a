#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>

#include "server/jobs/folder/job_folder.hpp"
#include "server/jobs/queue/job_views.hpp"
#include "server/jobs/queue/queue_state.hpp"

namespace dccast::jobs {

/// The request id of a submission belongs to another one.
struct RequestIdTaken : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// The daemon is ending and takes no jobs.
struct ShuttingDown : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// The queue is held because the daemon cannot write.
struct StorageHeld : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Accepts new jobs. Safe to use from several threads.
class Submissions {
public:
  Submissions(QueueState& state, JobViews& views) : state_(state), views_(views) {}

  /// See Scheduler::submit().
  v1::Job submit(const NewJob& new_job, const Attachments& attachments);

private:
  /// The present state of a job that was submitted before.
  v1::Job current(const v1::Job& job);
  /// @throws StorageHeld, QueueFull
  /// @param bytes  size of case and attachments
  void require_room(std::int64_t bytes);
  /// Writes folder, row and mark of a new job.
  /// @return the job of another submission that has used the same request id meanwhile; empty on
  ///         success
  std::optional<v1::Job> write_new_job(JobRecord& record, const NewJob& new_job,
                                       const Attachments& attachments);

  QueueState& state_;
  JobViews& views_;
  int under_way_ = 0;  ///< submissions in progress, which count as waiting jobs
};

}  // namespace dccast::jobs
