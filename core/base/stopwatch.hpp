#pragma once

#include <chrono>

namespace dccast {

/// Adds the time from its construction to its destruction to a sum. It measures wall time: reading
/// the processor time of a thread is a system call, and the hundreds of calls per step would cost 2
/// % of a 2D run.
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
