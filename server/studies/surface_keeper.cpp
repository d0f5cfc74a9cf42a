#include "server/studies/surface_keeper.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <utility>

#include "server/jobs/log.hpp"

namespace dccast::studies {

namespace {

// Runs that end within this time are handled together.
constexpr std::chrono::milliseconds gathering_time{500};

/// Lowers the priority of the calling thread (on Linux priorities are per thread), if permitted.
void step_back() {
  constexpr int steps_behind = 10;  // like the workers of jobs
  const int now = ::getpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()));
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), now + steps_behind);
}

}  // namespace

void SurfaceKeeper::start(Build build) {
  build_ = std::move(build);
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

void SurfaceKeeper::stop() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

void SurfaceKeeper::look_at(const std::string& study) {
  const std::lock_guard lock(mutex_);
  to_look_at_.insert(study);
  changed_.notify_all();
}

void SurfaceKeeper::build(const std::string& study) const {
  try {
    build_(study);
  } catch (const std::exception& error) {
    log::warn("study {}: its response surface is not built yet: {}", study, error.what());
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

    changed_.wait_for(lock, stop, gathering_time, [] { return false; });  // or the end
  }
}

}  // namespace dccast::studies
