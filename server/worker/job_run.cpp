#include "server/worker/job_run.hpp"

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <condition_variable>
#include <iostream>
#include <limits>
#include <utility>

#include "server/jobs/step_index.hpp"

namespace dccast::worker {

namespace {

constexpr int exit_daemon_gone = 70;

/// Between two synchronisations of the log, the most that a crash of the machine takes back.
constexpr std::chrono::milliseconds sync_interval{500};

/// From the request to stop, because no daemon came, to the end of the process: for a run that is
/// in the middle of a long step.
constexpr std::chrono::seconds last_step_time{60};

// Set by a signal handler, read by the thread of the run: only a lock-free atomic serves both.
std::atomic<bool> terminated = false;
static_assert(std::atomic<bool>::is_always_lock_free);

extern "C" void note_termination(int) {
  terminated = true;
}

JobRun::Clock::duration duration_of(double seconds) {
  return std::chrono::duration_cast<JobRun::Clock::duration>(
      std::chrono::duration<double>(seconds));
}

/// The files of the run are whole at any moment: the next attempt goes on from the checkpoint.
[[noreturn]] void leave(const std::string& why) {
  std::cerr << "dccast-worker: " << why << std::endl;
  ::_exit(exit_daemon_gone);
}

}  // namespace

void JobRun::prepare_signals() {
  ::signal(SIGTERM, note_termination);
}

JobRun::JobRun(const v1::SolveCase& order, const jobs::FolderClaim& claim)
    : folder_(order.directory()),
      claim_(claim),
      heartbeat_(duration_of(order.heartbeat_interval_s())),
      patience_(duration_of(order.daemon_patience_s())),
      log_(folder_ / "events.log"),
      daemon_seen_(Clock::now()) {
  log_.take_over();
  keeper_ = std::jthread([this](const std::stop_token& stop) { keep(stop); });
}

JobRun::~JobRun() = default;

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

/// Without a daemon the run stops at a checkpoint after a while, and the process ends at last. A
/// daemon is there as long as it touches its file.
void JobRun::look_for_daemon(Clock::time_point now) {
  std::error_code ignored;
  const auto sign =
      std::filesystem::last_write_time(jobs::daemon_file(folder_.parent_path()), ignored);
  if (std::exchange(daemon_sign_, sign) != sign) daemon_seen_ = now;
  if (patience_ == Clock::duration::zero()) return;
  const auto waited = now - daemon_seen_;
  if (waited > patience_ + last_step_time) leave("no dccastd came, and the run does not stop");
  if (waited <= patience_ || gave_up_.exchange(true)) return;
  std::cerr << "dccast-worker: no dccastd came: the run stops at a checkpoint" << std::endl;
}

void JobRun::keep(const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any stopped;
  std::unique_lock lock(mutex);
  auto next_sign = Clock::now();
  while (!stop.stop_requested()) {
    const auto now = Clock::now();
    if (const std::string loss = claim_.loss(); !loss.empty()) leave(loss);
    if (heartbeat_ > Clock::duration::zero() && now >= next_sign) {
      claim_.touch();
      next_sign = now + heartbeat_;
    }
    look_for_daemon(now);
    try {
      log_.sync();
    } catch (const std::system_error& error) {
      std::cerr << "dccast-worker: " << error.what() << std::endl;  // the next event is refused
    }
    const auto interval = heartbeat_ > Clock::duration::zero()
                              ? std::min<Clock::duration>(sync_interval, heartbeat_)
                              : Clock::duration(sync_interval);
    stopped.wait_for(lock, stop, interval, [] { return false; });
  }
}

}  // namespace dccast::worker
