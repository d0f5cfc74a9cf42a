#include "server/studies/study_feeder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "proto/case_file/source_map.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/log.hpp"
#include "server/studies/study_file.hpp"

namespace dccast::studies {

namespace {

constexpr std::chrono::seconds try_again{1};  // after the queue or the disk took nothing
constexpr int most_crashed_checks = 3;        // of one run

jobs::NewJob new_job(const StudyRecord& study, const jobs::Attachments& attachments,
                     const PlannedRun& planned, const intake::ExaminedCase& examined) {
  jobs::NewJob made = intake::new_job(planned.description, attachments, examined);
  v1::Job& job = made.description.job;
  job.set_study(study.id);
  // A study must not delay a query, unless its request sets a priority.
  job.set_priority(study.request.priority() == v1::PRIORITY_UNSPECIFIED ? v1::LOW
                                                                        : study.request.priority());
  job.set_owner(study.owner);
  *job.mutable_labels() = study.request.labels();
  *job.mutable_changes() = study.request.changes();
  job.mutable_changes()->Add(planned.changes.begin(), planned.changes.end());
  return made;
}

}  // namespace

void StudyFeeder::start() {
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

void StudyFeeder::stop() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

void StudyFeeder::wake() {
  const std::lock_guard lock(mutex_);
  woken_ = true;
  changed_.notify_all();
}

void StudyFeeder::wait(const std::stop_token& stop, std::chrono::steady_clock::duration most) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, stop, most, [this] { return woken_; });
  woken_ = false;
}

void StudyFeeder::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    try {
      for (bool more = true; more && !stop.stop_requested();) {
        more = false;
        for (const std::string& id : state_.store.to_feed()) more = feed(id) || more;
      }
      wait(stop, std::chrono::hours(24));
    } catch (const std::exception& error) {
      log::warn("runs of studies cannot be queued now, next attempt in {} s: {}", try_again.count(),
                error.what());
      wait(stop, try_again);
    }
  }
}

bool StudyFeeder::feed(const std::string& id) {
  if (state_.store.counts(id).waiting >= state_.options.waiting) return false;
  const auto study = state_.store.find(id);
  const auto run = state_.store.next_to_queue(id);
  if (!study || !run) return false;

  const auto plan = state_.plan_of(*study);
  bool more = true;
  if (run->number < plan->runs())
    queue_run(*study, *run, plan->run(run->number));
  else
    more = queue_next_run(*study, *plan, *run);

  state_.note_change(id);
  return more;
}

bool StudyFeeder::queue_next_run(const StudyRecord& study, const StudyPlan& plan,
                                 const RunRecord& run) {
  const auto before = results_.evaluated_runs(
      study, {.faces = plan.needs_faces(), .before = plan.rests_on(run.number)});

  bool goes_on = true;
  for (const EvaluatedRun& other : before) {
    if (!jobs::is_terminal(other.run.state())) return false;
    const bool outlasted = plan.outlasts_failures() && other.run.state() == v1::FAILED;
    goes_on = goes_on && (other.succeeded() || outlasted);
  }

  std::optional<PlannedRun> next;
  if (goes_on) {
    // A run whose face cannot be read gives no next mould.
    const auto has_fault = [](const EvaluatedRun& other) { return !other.face_fault.empty(); };
    const auto unread = std::ranges::find_if(before, has_fault);
    if (unread != before.end()) {
      refuse(study, run,
             fmt::format("the face of job {}, from which this run follows, cannot be used: {}",
                         unread->run.job(), unread->face_fault));
      return true;
    }
    next = plan.next(run.number, before);
  }

  if (next)
    queue_run(study, run, *next);
  else
    state_.store.drop(study.id, run.number);
  return true;
}

void StudyFeeder::queue_run(const StudyRecord& study, const RunRecord& run,
                            const PlannedRun& planned) {
  const RunName name{study.id, run.number};
  try {
    const auto attachments = study_attachments(state_.options.directory, study);
    const auto deadline = std::chrono::steady_clock::now() + state_.options.check_timeout;
    const auto examined =
        state_.intake.examine(planned.description, attachments, {}, {.deadline = deadline});
    crashed_checks_.erase(name);

    if (examined.verdict.faults_size() > 0)
      refuse(study, run,
             fmt::format("{} is refused: {}", planned.name,
                         case_file::describe(examined.verdict.faults(0), {})));
    else
      make_job(study, run, planned.key, new_job(study, attachments, planned, examined));
  } catch (const jobs::WorkerDidNotAnswer& error) {
    // A case that brings down workers repeatedly is itself at fault.
    if (error.why() == jobs::WorkerDidNotAnswer::Why::not_started) throw;
    if (++crashed_checks_[name] < most_crashed_checks) return;
    crashed_checks_.erase(name);
    refuse(study, run, error.what());
  } catch (const jobs::RequestIdTaken& error) {
    refuse(study, run, error.what());
  }
}

void StudyFeeder::make_job(const StudyRecord& study, RunRecord run, const std::string& key,
                           jobs::NewJob job) {
  const std::lock_guard lock(state_.queueing_mutex);
  const auto next = state_.store.next_to_queue(study.id);
  if (!next || next->number != run.number) return;  // cancelled meanwhile

  v1::Job queued;
  // Skip a job that was made before a crash and cancelled after it, and one of another user with
  // this request_id: neither belongs to this attempt.
  do {
    job.description.job.set_request_id(job_request_id(study.id, key, ++run.attempt));
    queued = state_.scheduler.submit(job, study_attachments(state_.options.directory, study));
  } while (queued.state() == v1::CANCELLED || queued.owner() != study.owner);

  run.job = queued.id();
  const auto plan = state_.plan_of(study);
  state_.store.set_job(study.id, run, plan->grows() && run.number + 1 < plan->most_runs());
}

void StudyFeeder::refuse(const StudyRecord& study, RunRecord run, const std::string& why) {
  run.outcome = v1::FAILED;
  run.failure.set_kind(v1::Finding::INVALID_CASE);
  run.failure.set_message(why);
  state_.append_to_file(study, {run});
  state_.store.refuse(study.id, run.number, run.failure, jobs::milliseconds(jobs::now()));
  log::warn("study {}: run {} failed without a job: {}", study.id, run.number + 1, why);
}

}  // namespace dccast::studies
