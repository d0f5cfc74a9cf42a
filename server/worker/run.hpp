#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "core/casting/casting_run.hpp"
#include "dccast/v1/worker.pb.h"
#include "server/jobs/executors/worker_claim.hpp"
#include "server/jobs/logs/event_log.hpp"

namespace dccast::worker {

inline constexpr int exit_daemon_gone = 70;

/// Receives the events of a run, and passes on requests to stop it.
class RunLink {
public:
  virtual ~RunLink() = default;
  /// @throws std::system_error  the event cannot be stored: the run must not continue
  virtual void send(v1::JobEvent event) = 0;
  virtual casting::Order order() const = 0;
  /// The valid reports of earlier attempts, from the first step on. @param most  number of reports
  virtual std::vector<v1::StepReport> steps(std::size_t /*most*/) const { return {}; }
  /// Waits until all sent events are on the disk. @throws std::system_error
  virtual void sync() {}
};

/// Runs a case to its end. Never throws: every fault is a failure of the job.
v1::RunEnd run_job(const v1::SolveCase& order, RunLink& link);

/// Makes the end of a failed run.
v1::RunEnd failed_run(v1::Finding::Kind kind, const std::string& message);

/// The run of a job in its folder: appends to the event log, sends heartbeats and reads requests.
/// It does not depend on a daemon; each daemon reads the same files.
class JobRun final : public RunLink {
public:
  using Clock = std::chrono::steady_clock;

  /// Makes SIGTERM a request to stop at a checkpoint.
  static void prepare_signals();

  /// @param claim  on the folder of the job; outlives this object
  /// @throws std::system_error  the log cannot be written
  JobRun(const v1::SolveCase& order, const jobs::FolderClaim& claim);

  /// Appends an event. Findings and the loss of validity are logged once, even if the run is
  /// resumed several times.
  void send(v1::JobEvent event) override;
  casting::Order order() const override;
  std::vector<v1::StepReport> steps(std::size_t most) const override;
  void sync() override { log_.sync(); }
  /// Writes the last record and syncs it to disk. @throws std::system_error
  void end(v1::RunEnd end);

private:
  void run_keeper(const std::stop_token& stop);
  void look_for_daemon(Clock::time_point now);

  const std::filesystem::path folder_;
  const jobs::FolderClaim& claim_;
  const Clock::duration heartbeat_;  ///< interval; zero: none
  const Clock::duration patience_;   ///< zero: the process ends with its daemon
  jobs::EventLog log_;
  std::atomic<bool> gave_up_ = false;  ///< no daemon appeared in time

  // Used only by the keeper thread.
  std::filesystem::file_time_type daemon_sign_;
  Clock::time_point daemon_seen_;
  std::jthread keeper_;
};

}  // namespace dccast::worker
