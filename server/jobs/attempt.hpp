#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "server/jobs/event_log.hpp"
#include "server/jobs/executor.hpp"
#include "server/jobs/job_store.hpp"

namespace dccast::jobs {

/// One try at a job, from the start of its worker until what became of the job is on the disk. The
/// scheduler's mutex guards it.
struct Attempt {
  using Clock = std::chrono::steady_clock;

  std::string job_id;
  int number = 0;  ///< counts the attempts at the job from 1
  std::shared_ptr<EventLog> log;
  bool adopted = false;  ///< its worker was started by an earlier daemon
  JobRecord record;

  std::optional<Clock::time_point> kill_at;
  std::string hung;                ///< why its worker was taken to hang and killed; empty: it was not
  std::optional<WorkerExit> exit;  ///< its process has ended
  std::string not_started;         ///< why there never was a worker; empty: there was one

  // Signs of life, see watchdog.hpp.
  bool begun = false;               ///< the worker has claimed the folder
  Clock::time_point looked;         ///< when the signs were looked at last
  Clock::time_point last_sign;      ///< when there was a new one; of the start until then
  Clock::time_point last_progress;  ///< when there was a new event
  std::optional<std::filesystem::file_time_type> sign{};
  std::int64_t sequence = 0;  ///< of the last event that was seen
};

}  // namespace dccast::jobs
