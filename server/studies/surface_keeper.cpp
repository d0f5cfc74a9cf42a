#include "server/studies/surface_keeper.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <exception>
#include <utility>

#include "server/jobs/log.hpp"

namespace dccast::studies {

namespace {

// Runs that end within it are taken together.
constexpr std::chrono::milliseconds least_interval{500};

/// On Linux the priority is that of a thread. Where it cannot be lowered the thread works on.
void step_back() {
  constexpr int steps_behind = 10;  // as the workers of jobs
  const int now = ::getpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()));
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), now + steps_behind);
}

}  // namespace

SurfaceKeeper::SurfaceKeeper(Ready ready)
    : ready_(std::move(ready)), thread_([this](const std::stop_token& stop) { run(stop); }) {}

void SurfaceKeeper::look_at(const std::string& study) {
  const std::lock_guard lock(mutex_);
  to_look_at_.insert(study);
  changed_.notify_all();
}

void SurfaceKeeper::stop() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

/// What cannot be built now is built when it is asked for.
void SurfaceKeeper::build(const std::string& study) const {
  try {
    ready_(study);
  } catch (const std::exception& error) {
    log::warn("study {}: no response surface yet: {}", study, error.what());
  }
}

void SurfaceKeeper::run(const std::stop_token& stop) {
  step_back();
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    changed_.wait(lock, stop, [this] { return !to_look_at_.empty(); });
    const std::set<std::string> studies = std::exchange(to_look_at_, {});
    lock.unlock();
    for (const std::string& study : studies)
      if (!stop.stop_requested()) build(study);
    lock.lock();
    changed_.wait_for(lock, stop, least_interval, [] { return false; });  // or the end
  }
}

}  // namespace dccast::studies
