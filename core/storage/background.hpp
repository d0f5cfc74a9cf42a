#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace dccast::storage {

/// Executes tasks one after the other in a thread of its own, so that a run does not wait for the
/// disk.
///
/// If a task throws, the following ones are dropped and the next call rethrows the exception.
class Background {
public:
  Background() = default;
  Background(const Background&) = delete;
  /// Finishes the posted tasks.
  ~Background();

  /// Waits only if two tasks are pending, to limit the memory that they hold.
  /// @throws std::system_error when no thread can be started; the task is dropped then
  void post(std::function<void()> task);
  /// Waits for every task.
  void wait();

private:
  /// The thread: executes tasks until the end, keeps the first exception.
  void run();
  /// Passes on the failure of a task to the caller of post() or wait(), once.
  void rethrow_background_error();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> tasks_;  ///< the first one is being executed
  std::exception_ptr failure_;
  bool ending_ = false;
  std::thread thread_;  ///< started by the first task
};

}  // namespace dccast::storage
