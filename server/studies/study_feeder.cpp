// Turns the runs of studies into jobs: one thread, a few runs of each study at a time, so that a
// thousand runs neither fill the queue nor delay later jobs. The store records the progress; after
// an interruption the last run is repeated, which gives the same job.

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "proto/case_file/source_map.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/log.hpp"
#include "server/studies/studies.hpp"

#include <fmt/format.h>

namespace dccast::studies {

namespace {

constexpr std::chrono::seconds try_again{1};  // after the queue or the disk took nothing
constexpr int most_unanswered = 3;            // checks of one run

jobs::NewJob new_job(const StudyRecord& study, const jobs::Attachments& attachments,
                     const PlannedRun& planned, const intake::ExaminedCase& examined) {
  jobs::NewJob job = intake::new_job(planned.description, attachments, examined);
  job.study = study.id;
  // A study must not delay a query, unless its request sets a priority.
  job.priority =
      study.request.priority() == v1::PRIORITY_UNSPECIFIED ? v1::LOW : study.request.priority();
  job.owner = study.owner;
  job.labels = {study.request.labels().begin(), study.request.labels().end()};
  job.changes = {study.request.changes().begin(), study.request.changes().end()};
  job.changes.insert(job.changes.end(), planned.changes.begin(), planned.changes.end());
  return job;
}

}  // namespace

void Studies::wake_feeder() {
  const std::lock_guard lock(feeder_mutex_);
  feeder_woken_ = true;
  feeder_wake_.notify_all();
}

void Studies::note_change(const std::string& id) {
  notifier_.note(id);
  surface_keeper_.look_at(id);
}

/// Waits until it is woken, at most for this time.
void Studies::rest(const std::stop_token& stop, std::chrono::steady_clock::duration most) {
  std::unique_lock lock(feeder_mutex_);
  feeder_wake_.wait_for(lock, stop, most, [this] { return feeder_woken_; });
  feeder_woken_ = false;
}

void Studies::feed(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    try {
      for (bool more = true; more && !stop.stop_requested();) {
        more = false;
        for (const std::string& id : store_.to_feed()) more = feed_study(id) || more;
      }
      rest(stop, std::chrono::hours(24));
    } catch (const std::exception& error) {
      log::warn("studies wait to be queued: {}", error.what());
      rest(stop, try_again);
    }
  }
}

/// Queues one run of a study if it has room. @return whether another look may queue more
/// @throws std::exception  nothing can be queued now
bool Studies::feed_study(const std::string& id) {
  if (store_.counts(id).waiting >= options_.waiting) return false;
  const auto study = store_.find(id);
  const auto run = store_.next_to_queue(id);
  if (!study || !run) return false;
  const auto plan = plan_of(*study);
  bool more = true;
  if (run->number < plan->runs())
    feed_run(*study, *run, plan->run(run->number));
  else
    more = feed_grown(*study, *plan, *run);
  note_change(id);
  return more;
}

/// Queues the next run of a growing plan, or drops it if the plan is finished. The run waits from
/// the moment the one before it is queued, so that the study does not end in between.
/// @return false: a run on which it depends has not ended
bool Studies::feed_grown(const StudyRecord& study, const StudyPlan& plan, const RunRecord& run) {
  const auto before =
      evaluated_runs(study, {.faces = plan.needs_faces(), .before = plan.rests_on(run.number)});

  std::optional<PlannedRun> next;
  bool stopped = false;
  for (const EvaluatedRun& other : before) {
    if (!jobs::is_terminal(other.run.state())) return false;
    stopped = stopped || (!other.succeeded() &&
                          !(plan.outlasts_failures() && other.run.state() == v1::FAILED));
  }

  if (!stopped) {
    // A run whose face cannot be read gives no next mould.
    for (const EvaluatedRun& other : before)
      if (!other.face_fault.empty()) {
        refuse(
            study, run,
            fmt::format("job {} says nothing of its mould: {}", other.run.job(), other.face_fault));
        return true;
      }
    next = plan.next(run.number, before);
  }

  if (next)
    feed_run(study, run, *next);
  else
    store_.drop(study.id, run.number);
  return true;
}

void Studies::feed_run(const StudyRecord& study, const RunRecord& run, const PlannedRun& planned) {
  using Why = jobs::WorkerDidNotAnswer::Why;
  try {
    const auto attachments = study_attachments(options_.directory, study);

    const auto examined =
        intake_.examine(planned.description, attachments, {},
                        {.deadline = std::chrono::steady_clock::now() + options_.check_timeout});

    if (examined.verdict.faults_size() > 0)
      refuse(study, run,
             fmt::format("{} is refused: {}", planned.name,
                         case_file::describe(examined.verdict.faults(0), {})));
    else
      make_job(study, run, planned.key, new_job(study, attachments, planned, examined));
  } catch (const jobs::WorkerDidNotAnswer& error) {
    // A case that brings down workers repeatedly is itself at fault.
    if (error.why() == Why::not_started) throw;
    const std::string key = study.id + "/" + std::to_string(run.number);
    if (++unanswered_[key] < most_unanswered) return;
    unanswered_.erase(key);
    refuse(study, run, error.what());
  } catch (const jobs::RequestIdTaken& error) {
    refuse(study, run, error.what());
  }
}

void Studies::make_job(const StudyRecord& study, RunRecord run, const std::string& key,
                       jobs::NewJob job) {
  const std::lock_guard lock(queueing_mutex_);
  const auto next = store_.next_to_queue(study.id);
  if (!next || next->number != run.number) return;  // cancelled meanwhile

  v1::Job queued;
  // Skip a job that was made before a crash and cancelled after it, and one of another user with
  // this request_id: neither belongs to this attempt.
  do {
    job.request_id = job_request_id(study.id, key, ++run.attempt);
    queued = scheduler_.submit(job, study_attachments(options_.directory, study));
  } while (queued.state() == v1::CANCELLED || queued.owner() != study.owner);

  run.job = queued.id();
  const auto plan = plan_of(study);
  store_.set_job(study.id, run, plan->grows() && run.number + 1 < plan->most_runs());
}

void Studies::refuse(const StudyRecord& study, RunRecord run, const std::string& why) {
  run.outcome = v1::FAILED;
  run.failure.set_kind(v1::Finding::INVALID_CASE);
  run.failure.set_message(why);
  keep(study, {run});
  store_.refuse(study.id, run.number, run.failure, jobs::milliseconds(jobs::now()));
  log::warn("study {}: {}", study.id, why);
}

}  // namespace dccast::studies
