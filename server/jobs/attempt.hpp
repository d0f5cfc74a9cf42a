#pragma once

#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "dccast/v1/worker.pb.h"
#include "server/jobs/event_log.hpp"
#include "server/jobs/job_store.hpp"

namespace dccast::jobs {

/// The daemon's end of the link to one worker.
class WorkerChannel {
public:
  virtual ~WorkerChannel() = default;
  /// Sends soon and never waits; nothing happens when the link is gone.
  virtual void send(const v1::WorkerOrder& order) = 0;
};

/// One try at a job, from the start of its worker to the end of that process.
struct Attempt {
  using Clock = std::chrono::steady_clock;

  // Fixed when the attempt begins.
  std::string job_id;
  int number = 0;            ///< counts the attempts at the job from 1
  std::string token_sha256;  ///< of what its worker proves itself with
  std::shared_ptr<EventLog> log;
  Clock::time_point begun;
  bool adopted = false;  ///< its worker was started by an earlier daemon

  // Of the scheduler's mutex.
  JobRecord record;
  std::shared_ptr<WorkerChannel> channel;  ///< once the worker has called
  bool called = false;                     ///< it has: to one daemon it calls once
  std::string solver;                      ///< identity of what it runs; empty: not known
  std::optional<Clock::time_point> kill_at;
  std::string hung;      ///< why its worker was taken to hang and killed; empty: it was not
  bool settled = false;  ///< what the job has become is decided; only the process is still there
  /// How the process ended, while its link still has words of it
  std::optional<std::string> ended;
  bool requeue = false;  ///< back into the queue when the process is gone

  // Of its own mutex, so that steps do not wait for the scheduler; taken after the scheduler's.
  std::mutex mutex;
  bool closed = false;             ///< nothing a worker says counts any more
  std::string storage_error;       ///< first event that could not be written; none is after it
  Clock::time_point last_word;     ///< when the worker last said anything
  Clock::time_point last_advance;  ///< when it called, resumed or reported a step
  std::int64_t acknowledged_reports = 0;  ///< up to which the worker need keep nothing
};

}  // namespace dccast::jobs
