#pragma once

#include <atomic>
#include <filesystem>
#include <string>
#include <vector>

#include "dccast/v1/config.pb.h"
#include "server/intake/case_intake.hpp"
#include "server/intake/uploads.hpp"
#include "server/jobs/executors/precedence.hpp"
#include "server/jobs/logs/event_logs.hpp"
#include "server/jobs/logs/step_index.hpp"
#include "server/jobs/queue/scheduler.hpp"
#include "server/jobs/recent.hpp"
#include "server/jobs/store/job_store.hpp"
#include "server/service/gate.hpp"
#include "server/studies/studies.hpp"

namespace dccast::service {

/// What a query was answered with, kept for the same query and for comparisons. As bytes: a message
/// takes three times their memory.
struct QueryAnswer {
  bool succeeded = false;             ///< the same query has the same answer
  std::string complete_case;          ///< v1::Case
  std::vector<std::string> messages;  ///< of QueryButtCurlResponse, behind `accepted`

  std::size_t bytes() const {
    std::size_t size = complete_case.capacity();
    for (const std::string& message : messages) size += sizeof message + message.capacity();
    return size;
  }
};

/// What the calls work with; owned by the daemon.
struct Context {
  const v1::DaemonConfig& settings;  ///< as daemon::resolved() has them
  jobs::Scheduler& scheduler;
  jobs::EventLogs& logs;
  jobs::JobStore& store;
  studies::Studies& studies;
  const intake::CaseIntake& intake;
  intake::Uploads& uploads;
  Gate& gate;
  jobs::WarmWorkers& warm_workers;
  jobs::Precedence& precedence;
  std::string solver;          ///< identity of the solver that the workers run; empty: not known
  std::string worker_sandbox;  ///< what holds the workers
  std::filesystem::path query_directory;  ///< where the runs of queries have their folders
  std::filesystem::path jobs_directory;
  std::string version;
  int workers = 1;  ///< jobs that run at once
  jobs::StepIndexes step_indexes{};
  /// Of queries that were not kept as jobs, by their answer_key(), which names them to
  /// CompareRuns; in bytes.
  jobs::Recent<const QueryAnswer> query_answers{16'000'000};
  std::atomic<bool> leaving{false};  ///< the daemon is shutting down: streams end
};

}  // namespace dccast::service
