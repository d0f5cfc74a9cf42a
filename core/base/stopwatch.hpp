#pragma once

#include <chrono>

namespace dccast {

/// Adds the wall time from its construction to its destruction to a sum. It does not measure
/// processor time: reading the clock of a thread is a system call, and the hundreds of calls in a
/// step would cost 2 % of a 2D run.
class Stopwatch {
public:
  /// @param seconds  [s] the sum that grows; must outlive the watch
  explicit Stopwatch(double& seconds) : seconds_(&seconds) {}
  /// Adds the time since construction.
  ~Stopwatch() {
    *seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

private:
  /// Sum to which the time is added [s].
  double* seconds_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace dccast
