#include "server/service/work_pool.hpp"

#include <spdlog/spdlog.h>

#include <exception>
#include <utility>

namespace dccast::service {

WorkPool::WorkPool(int threads, std::size_t maximum_waiting) : maximum_waiting_(maximum_waiting) {
  for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { run(); });
}

WorkPool::~WorkPool() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  changed_.notify_all();
}

bool WorkPool::post(std::function<void()> work) {
  {
    const std::lock_guard lock(mutex_);
    if (waiting_.size() >= maximum_waiting_) return false;
    waiting_.push_back(std::move(work));
  }
  changed_.notify_one();
  return true;
}

void WorkPool::run() {
  for (;;) {
    std::function<void()> work;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return closed_ || !waiting_.empty(); });
      if (waiting_.empty()) return;
      work = std::move(waiting_.front());
      waiting_.pop_front();
    }
    try {
      work();
    } catch (const std::exception& error) {
      // Whoever posts catches what it can name to its caller; this is what nobody foresaw.
      spdlog::critical("posted work has thrown: {}", error.what());
    }
  }
}

}  // namespace dccast::service
