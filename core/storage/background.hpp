#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace dccast::storage {

/// Does tasks one after the other in a thread of its own, so that a run need not wait for the disk.
///
/// After a task that threw, those behind it are dropped; the exception comes out of the next call.
class Background {
public:
  Background() = default;
  Background(const Background&) = delete;
  /// Finishes the tasks that were posted.
  ~Background();

  /// Waits only when the thread is two tasks behind: what they hold must not pile up.
  void post(std::function<void()> task);
  /// Waits for every task.
  void wait();

private:
  void run();
  void rethrow_background_error();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> tasks_;  ///< the first one is being done
  std::exception_ptr failure_;
  bool ending_ = false;
  std::thread thread_;  ///< begins with the first task
};

}  // namespace dccast::storage
