#pragma once

#include <chrono>

namespace dccast {

/// Adds the seconds of its life to a sum. Wall time: that of a thread is a system call, and hundreds
/// a step would be 2 % of a plane run.
class Stopwatch {
public:
  /// @param seconds  [s] the sum; must outlive the watch
  explicit Stopwatch(double& seconds) : seconds_(&seconds) {}
  ~Stopwatch() {
    *seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

private:
  double* seconds_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace dccast
