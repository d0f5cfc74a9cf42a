#pragma once

#include <atomic>

namespace dccast::jobs {

/// No file of this name can be read by this process while one lives: EIO, as of a sector that is
/// worn out. Other files can.
class FailingRead {
public:
  /// @param path  its end, e.g. "JOB/events.log"; it outlives this object
  explicit FailingRead(const char* path) { fails = path; }
  FailingRead(const FailingRead&) = delete;
  ~FailingRead() { fails = nullptr; }

  static inline std::atomic<const char*> fails = nullptr;
};

}  // namespace dccast::jobs
