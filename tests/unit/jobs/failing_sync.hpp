#pragma once

#include <atomic>

namespace dccast::jobs {

/// No fdatasync() of this process succeeds while one lives: EROFS. Writing works.
class FailingSync {
public:
  FailingSync() : failures_before_(failures) { fails = true; }
  FailingSync(const FailingSync&) = delete;
  ~FailingSync() { fails = false; }
  bool has_failed() const { return failures > failures_before_; }

  static inline std::atomic<bool> fails = false;
  static inline std::atomic<int> failures = 0;

private:
  const int failures_before_;
};

}  // namespace dccast::jobs
