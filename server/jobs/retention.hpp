#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <thread>

#include "server/jobs/scheduler.hpp"

namespace dccast::jobs {

struct RetentionOptions {
  std::filesystem::path jobs_directory;
  std::chrono::seconds time{0};  ///< jobs that ended longer ago are deleted; 0: never
  std::int64_t bytes = 0;        ///< that ended jobs may hold; beyond, the oldest go; 0: no bound
  std::chrono::milliseconds interval{10000};
};

/// Measures at the start what ended jobs hold, and deletes old ones, as a request would. Pinned
/// ones, those of studies and those that a job waits for stay, and count nothing. Deletes nothing
/// while the queue is held.
class Retention {
public:
  Retention(RetentionOptions options, JobStore& store, Scheduler& scheduler);

private:
  void run(const std::stop_token& stop);
  void measure(const std::stop_token& stop);
  void look();
  bool remove(const JobStore::Ended& job, const char* why);

  const RetentionOptions options_;
  JobStore& store_;
  Scheduler& scheduler_;
  std::jthread thread_;
};

}  // namespace dccast::jobs
