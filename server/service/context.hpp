#pragma once

#include <atomic>
#include <chrono>
#include <string>
#include <vector>

#include "server/intake/case_intake.hpp"
#include "server/jobs/event_logs.hpp"
#include "server/jobs/job_store.hpp"
#include "server/jobs/recent.hpp"
#include "server/jobs/scheduler.hpp"
#include "server/jobs/step_index.hpp"
#include "server/service/gate.hpp"
#include "server/studies/studies.hpp"

namespace dccast::service {

/// What a query was answered with behind `accepted`: messages of QueryButtCurlResponse.
using QueryAnswer = std::vector<std::string>;

/// What the calls work with; owned by the daemon.
struct Context {
  jobs::Scheduler& scheduler;
  jobs::EventLogs& logs;
  jobs::JobStore& store;
  studies::Studies& studies;
  const intake::CaseIntake& intake;
  Gate& gate;
  jobs::WarmWorkers& warm_workers;
  std::string solver;          ///< identity of the solver that the workers run; empty: not known
  std::string worker_sandbox;  ///< what holds the workers
  std::filesystem::path query_directory;  ///< where the runs of queries have their folders
  jobs::StepIndexes step_indexes{};
  /// Of queries that were not kept as jobs, by their answer_key(), in bytes.
  jobs::Recent<const QueryAnswer> query_answers{16'000'000};
  std::filesystem::path jobs_directory;
  std::string version;
  int workers = 1;
  int maximum_queued = 0;
  int maximum_queued_per_user = 0;
  double maximum_time_s = 0.0;               ///< of a job; 0: no limit
  double maximum_disk_per_user_bytes = 0.0;  ///< 0: no limit
  std::int64_t token_lifetime_s = 0;
  std::int64_t maximum_message_bytes = 0;
  int checks_at_once = 1;
  int queries_at_once = 1;
  int query_threads = 1;  ///< of a quarter slab
  int maximum_waiting_checks = 1;
  std::chrono::milliseconds check_timeout{30000};
  std::size_t maximum_connections = 1;
  std::atomic<bool> leaving{false};  ///< the daemon is shutting down: streams end
};

}  // namespace dccast::service
