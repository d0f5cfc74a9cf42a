#include "server/worker/run.hpp"

#include <fmt/core.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <condition_variable>
#include <iostream>
#include <limits>
#include <mutex>
#include <new>
#include <system_error>
#include <utility>

#include "core/casting/case/judged_monitor.hpp"
#include "core/casting/simulation.hpp"
#include "core/storage/storage_error.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/values/digests.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "server/jobs/logs/step_index.hpp"
#include "server/translate/enumerations.hpp"
#include "server/translate/translate.hpp"
#include "server/worker/followed_levers.hpp"
#include "server/worker/run_facts.hpp"

namespace dccast::worker {

namespace {

namespace fs = std::filesystem;

/// Interval at which the log is synced: a crash of the machine loses at most the last events.
constexpr std::chrono::milliseconds sync_interval{500};

/// Time to finish a long step after the run was stopped for lack of a daemon; then the process
/// ends.
constexpr std::chrono::seconds last_step_time{60};

// Set by a signal handler and read by the thread of the run, so it must be a lock-free atomic.
std::atomic<bool> terminated = false;
static_assert(std::atomic<bool>::is_always_lock_free);

extern "C" void note_termination(int) {
  terminated = true;
}

JobRun::Clock::duration to_duration(double seconds) {
  return std::chrono::duration_cast<JobRun::Clock::duration>(
      std::chrono::duration<double>(seconds));
}

/// Ends the process. The files of the run are consistent at any moment, so the next attempt
/// continues from the checkpoint.
[[noreturn]] void leave(const std::string& why) {
  std::cerr << "dccast-worker: " << why << std::endl;
  ::_exit(exit_daemon_gone);
}

/// Converts reports of the run to events, and passes on requests to stop.
class ReportingObserver : public casting::StepObserver {
public:
  ReportingObserver(RunLink& link, const casting::Case& casting_case,
                    std::vector<std::optional<v1::RelativeError>> errors,
                    const std::optional<FollowedLevers>& levers)
      : link_(link), case_(casting_case), errors_(std::move(errors)), levers_(levers) {}

  casting::Order on_step(const results::StepReport& report) override {
    send([&](v1::JobEvent& event) {
      *event.mutable_step() = translate::to_proto(report, case_.monitors, errors_);
      const auto judged = casting::judged_monitor(case_, report.monitor_displacement);
      if (judged) event.mutable_step()->mutable_monitors(int(*judged))->set_judged(true);
    });
    return link_.order();
  }

  std::vector<results::StepReport> reported_steps(std::int64_t step) override {
    std::vector<results::StepReport> reports;
    for (const v1::StepReport& each : link_.steps(static_cast<std::size_t>(step)))
      reports.push_back(translate::to_core(each, mesh::dimension_of(case_.section.kind)));
    return reports;
  }

  void sync_reports() override { link_.sync(); }

  void on_resumed(std::int64_t step, double time) override {
    send([&](v1::JobEvent& event) {
      event.mutable_resumed()->set_step(step);
      event.mutable_resumed()->set_time_s(time);
    });
  }

  void on_validity_lost(const results::ValidityLoss& loss) override {
    send([&](v1::JobEvent& event) { *event.mutable_validity_lost() = translate::to_proto(loss); });
  }

  void on_finding(const results::Finding& finding) override {
    send([&](v1::JobEvent& event) {
      *event.mutable_finding() = translate::to_proto(finding);
      // No other lever mends what one that is off its plan does.
      const std::string first =
          levers_ && finding.time ? levers_->remedy_at(*finding.time) : std::string();
      if (!first.empty()) event.mutable_finding()->set_remedy(first);
    });
  }

  void on_message(std::string_view text) override {
    link_.send(jobs::message_event(std::string(text), v1::JobEvent::Message::INFO));
  }

private:
  template <class Fill>
  void send(Fill fill) {
    v1::JobEvent event;
    fill(event);
    link_.send(std::move(event));
  }

  RunLink& link_;
  const casting::Case& case_;
  const std::vector<std::optional<v1::RelativeError>> errors_;  ///< by monitor
  const std::optional<FollowedLevers>& levers_;                 ///< empty: the case is not followed
};

/// Lists the results with sizes and checksums. They are computed here, once, while the files are
/// still in the page cache.
void add_artifacts(const fs::path& directory, v1::RunEnd& finished) {
  for (const char* name : {"results.h5", "results.xdmf", "results-end.xdmf"}) {
    if (!fs::exists(directory / name)) continue;
    auto* artifact = finished.add_artifacts();
    artifact->set_name(name);
    artifact->set_size_bytes(static_cast<std::int64_t>(fs::file_size(directory / name)));
    artifact->set_sha256(values::sha256_of_file(directory / name));
  }
}

v1::RunEnd make_run_end(const casting::RunOutcome& outcome, const v1::SolveCase& order) {
  v1::RunEnd finished;
  finished.set_outcome(translate::to_proto(outcome.end));
  if (!outcome.failures.empty())
    *finished.mutable_failure() = translate::to_proto(outcome.failures);

  const bool ended =
      outcome.end == casting::RunEnd::succeeded || outcome.end == casting::RunEnd::failed;
  if (!ended || order.job_id().empty()) return finished;

  try {
    add_artifacts(order.directory(), finished);
  } catch (const std::system_error& error) {
    // The failure of the run itself remains the cause.
    if (!finished.has_failure()) return failed_run(v1::Finding::STORAGE, error.what());
    v1::Finding& further = *finished.mutable_failure()->add_further();
    further.set_kind(v1::Finding::STORAGE);
    further.set_message(error.what());
  }
  return finished;
}

v1::RunEnd run(const v1::SolveCase& order, RunLink& link) {
  const fs::path directory = order.directory();
  auto casting_case = translate::to_core(order.case_(), directory / jobs::attachments_folder);
  casting_case.commit = commit;
  if (!order.job_id().empty())
    casting_case.case_sha256 = jobs::read_job_description(directory).job.case_sha256();

  std::optional<FollowedLevers> levers;
  if (!order.job_id().empty() && jobs::follows_readings(directory))
    levers.emplace(directory, order.case_(), [&link] { return link.order(); });
  std::vector<std::optional<v1::RelativeError>> errors;
  for (const v1::Monitor& monitor : order.case_().monitor())
    errors.push_back(case_file::monitor_error(order.case_(), monitor.name()));
  ReportingObserver observer(link, casting_case, std::move(errors), levers);

  const auto outcome =
      casting::run(casting_case,
                   {.path = directory,
                    .resume = order.resume(),
                    .other_version = translate::to_core(order.other_version()),
                    .leaves_run_files = true,
                    .keeps_nothing = order.job_id().empty()},
                   observer, std::max(order.threads(), 1), levers ? &*levers : nullptr);

  return make_run_end(outcome, order);
}

}  // namespace

v1::RunEnd failed_run(v1::Finding::Kind kind, const std::string& message) {
  v1::RunEnd end;
  end.set_outcome(v1::RunEnd::FAILED);
  end.mutable_failure()->set_kind(kind);
  end.mutable_failure()->set_message(message);
  return end;
}

v1::RunEnd run_job(const v1::SolveCase& order, RunLink& link) {
  try {
    return run(order, link);
  } catch (const InvalidCase& error) {
    return failed_run(v1::Finding::INVALID_CASE, translate::describe(error.faults()));
  } catch (const jobs::DamagedReadings& error) {
    return failed_run(v1::Finding::STORAGE, error.what());
  } catch (const std::system_error& error) {
    if (storage::is_memory_fault(error.code()))
      return failed_run(v1::Finding::OUT_OF_MEMORY, jobs::out_of_memory_text);
    return failed_run(v1::Finding::STORAGE, error.what());
  } catch (const std::bad_alloc&) {
    return failed_run(v1::Finding::OUT_OF_MEMORY, jobs::out_of_memory_text);
  } catch (const std::exception& error) {
    return failed_run(v1::Finding::INTERNAL, error.what());
  }
}

void JobRun::prepare_signals() {
  ::signal(SIGTERM, note_termination);
}

JobRun::JobRun(const v1::SolveCase& order, const jobs::FolderClaim& claim)
    : folder_(order.directory()),
      claim_(claim),
      heartbeat_(to_duration(order.heartbeat_interval_s())),
      patience_(to_duration(order.daemon_patience_s())),
      log_(folder_ / "events.log"),
      daemon_seen_(Clock::now()) {
  log_.take_over();
  keeper_ = std::jthread([this](const std::stop_token& stop) { run_keeper(stop); });
}

void JobRun::send(v1::JobEvent event) {
  if (!log_.knows(event)) log_.append(event);
}

std::vector<v1::StepReport> JobRun::steps(std::size_t most) const {
  auto page = jobs::StepIndex().page(log_, {}, most, std::numeric_limits<std::size_t>::max());
  return std::move(page.value().steps);
}

casting::Order JobRun::order() const {
  const auto request = jobs::read_request(folder_);
  if (request && request->action == jobs::RequestedAction::cancel) return casting::Order::cancel;
  return request || terminated || gave_up_ ? casting::Order::stop_at_checkpoint
                                           : casting::Order::go_on;
}

void JobRun::end(v1::RunEnd end) {
  v1::JobEvent event;
  *event.mutable_run_ended() = std::move(end);
  log_.append(event);
  log_.sync();
}

/// Without a daemon the run stops at a checkpoint after a while, and finally the process ends. A
/// running daemon touches its file.
void JobRun::look_for_daemon(Clock::time_point now) {
  std::error_code ignored;
  const auto sign =
      std::filesystem::last_write_time(jobs::daemon_file(folder_.parent_path()), ignored);
  if (std::exchange(daemon_sign_, sign) != sign) daemon_seen_ = now;
  if (patience_ == Clock::duration::zero()) return;

  const auto waited = now - daemon_seen_;
  if (waited > patience_ + last_step_time)
    leave("no dccastd is running, and the run does not stop");
  if (waited <= patience_ || gave_up_.exchange(true)) return;
  std::cerr << "dccast-worker: no dccastd is running; stopping at a checkpoint" << std::endl;
}

void JobRun::run_keeper(const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any stopped;
  std::unique_lock lock(mutex);
  const bool sends_heartbeats = heartbeat_ > Clock::duration::zero();
  const Clock::duration interval =
      sends_heartbeats ? std::min<Clock::duration>(sync_interval, heartbeat_) : sync_interval;

  auto next_heartbeat = Clock::now();
  while (!stop.stop_requested()) {
    const auto now = Clock::now();
    if (const std::string loss = claim_.loss(); !loss.empty()) leave(loss);

    if (sends_heartbeats && now >= next_heartbeat) {
      claim_.touch();
      next_heartbeat = now + heartbeat_;
    }
    look_for_daemon(now);

    try {
      log_.sync();
    } catch (const std::system_error& error) {
      std::cerr << "dccast-worker: " << error.what() << std::endl;  // the next event is refused
    }

    stopped.wait_for(lock, stop, interval, [] { return false; });
  }
}

}  // namespace dccast::worker
