#pragma once

#include <ctime>

namespace dccast {

/// Processor seconds of the calling thread.
inline double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Adds the processor seconds of its life on this thread to a sum.
class Stopwatch {
public:
  /// @param seconds  [s] the sum; must outlive the watch
  explicit Stopwatch(double& seconds) : seconds_(&seconds), start_(thread_seconds()) {}
  ~Stopwatch() { *seconds_ += thread_seconds() - start_; }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

private:
  double* seconds_;
  double start_;
};

}  // namespace dccast
