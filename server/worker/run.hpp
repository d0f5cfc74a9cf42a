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

/// Where the events of a run go, and where requests to stop it come from.
class RunLink {
public:
  virtual ~RunLink() = default;
  /// @throws std::system_error  the event cannot be kept: the run must not go on
  virtual void send(v1::JobEvent event) = 0;
  virtual casting::Order order() const = 0;
  /// The reports of the first steps that earlier attempts have sent, as the run that goes on has
  /// them; at most so many.
  virtual std::vector<v1::StepReport> steps(std::size_t) const { return {}; }
  /// Waits until what was sent is on the disk. @throws std::system_error
  virtual void sync() {}
};

/// Runs a case to its end. Never throws: whatever goes wrong is a failure of the job.
v1::RunEnd run_job(const v1::SolveCase& order, RunLink& link);

/// The end of a run that failed.
v1::RunEnd failed_run(v1::Failure::Kind kind, const std::string& message);

/// The run of a job, in the folder of the job: appends to its event log, gives signs of life, and
/// looks for requests. It needs no daemon; the daemons that come and go read the same files.
class JobRun final : public RunLink {
public:
  using Clock = std::chrono::steady_clock;

  /// Makes SIGTERM a request to stop at a checkpoint, from now on.
  static void prepare_signals();

  /// @param claim  on the folder of the job; outlives this
  /// @throws std::system_error  the log cannot be written
  JobRun(const v1::SolveCase& order, const jobs::FolderClaim& claim);

  /// Findings and the loss of validity stand in the log once, however often the run goes on from a
  /// checkpoint.
  void send(v1::JobEvent event) override;
  casting::Order order() const override;
  std::vector<v1::StepReport> steps(std::size_t most) const override;
  void sync() override { log_.sync(); }
  /// The last record, on the disk when this returns. @throws std::system_error
  void end(v1::RunEnd end);

private:
  void keep(const std::stop_token& stop);
  void look_for_daemon(Clock::time_point now);

  const std::filesystem::path folder_;
  const jobs::FolderClaim& claim_;
  const Clock::duration heartbeat_;  ///< zero: none
  const Clock::duration patience_;   ///< zero: the process ends with its daemon
  jobs::EventLog log_;
  std::atomic<bool> gave_up_ = false;  ///< no daemon came in time

  // Of the thread that keeps.
  std::filesystem::file_time_type daemon_sign_;
  Clock::time_point daemon_seen_;
  std::jthread keeper_;
};

}  // namespace dccast::worker
