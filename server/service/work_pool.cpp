#include "server/service/work_pool.hpp"

#include <exception>
#include <utility>

#include "server/jobs/log.hpp"

namespace dccast::service {

WorkPool::WorkPool(int threads, const WaitingBound& bound) : bound_(bound) {
  for (int i = 0; i < threads; ++i)
    threads_.emplace_back([this](const std::stop_token& stop) { run(stop); });
}

bool WorkPool::post(std::function<void()> work, std::size_t bytes) {
  {
    const std::lock_guard lock(mutex_);
    const bool too_large = !waiting_.empty() && waiting_bytes_ + bytes > bound_.bytes;
    if (too_large || waiting_.size() >= bound_.number) return false;
    waiting_.push_back({std::move(work), bytes});
    waiting_bytes_ += bytes;
  }
  changed_.notify_one();
  return true;
}

void WorkPool::run(const std::stop_token& stop) {
  for (;;) {
    std::function<void()> work;
    {
      std::unique_lock lock(mutex_);
      if (!changed_.wait(lock, stop, [this] { return !waiting_.empty(); })) return;
      work = std::move(waiting_.front().work);
      waiting_bytes_ -= waiting_.front().bytes;
      waiting_.pop_front();
    }

    try {
      work();
    } catch (const std::exception& error) {
      // Posted work reports its errors to its caller: an exception here is a bug.
      log::critical("a thread of the service caught an exception of posted work: {}", error.what());
    }
  }
}

}  // namespace dccast::service
