#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "dccast/v1/config.pb.h"
#include "server/intake/case_intake.hpp"
#include "server/intake/uploads.hpp"
#include "server/jobs/executors/precedence.hpp"
#include "server/jobs/logs/event_logs.hpp"
#include "server/jobs/logs/readings_log.hpp"
#include "server/jobs/logs/step_index.hpp"
#include "server/jobs/queue/scheduler.hpp"
#include "server/jobs/recent.hpp"
#include "server/jobs/store/job_store.hpp"
#include "server/levers/casting_progress.hpp"
#include "server/service/gate.hpp"
#include "server/studies/lines.hpp"
#include "server/studies/studies.hpp"

namespace dccast::service {

/// Stored answer of a query, for repetitions of the query and for comparisons. Messages are kept
/// serialised: parsed ones take three times the memory.
struct QueryAnswer {
  bool succeeded = false;             ///< only then a repeated query receives it
  std::string complete_case;          ///< v1::Case
  std::vector<std::string> messages;  ///< QueryButtCurlResponse, all after `accepted`

  /// Memory of the answer, for the bound on all answers [bytes].
  std::size_t bytes() const {
    std::size_t size = complete_case.capacity();
    for (const std::string& message : messages) size += sizeof message + message.capacity();
    return size;
  }
};

/// How many warnings the latest forecast of each job had. Safe to use from several threads.
class LatestWarnings {
public:
  void set(const std::string& job, int warnings) {
    const std::lock_guard lock(mutex_);
    by_job_[job] = warnings;
  }
  /// Their sum over these jobs; others are forgotten.
  int sum_of(const std::set<std::string>& jobs) {
    const std::lock_guard lock(mutex_);
    std::erase_if(by_job_, [&](const auto& entry) { return !jobs.contains(entry.first); });
    int sum = 0;
    for (const auto& [job, warnings] : by_job_) sum += warnings;
    return sum;
  }

private:
  std::mutex mutex_;
  std::map<std::string, int> by_job_;
};

/// The record of a job that follows a casting, read as far as it went at the last question.
/// Safe to use from several threads.
class FollowedRecord {
public:
  /// @throws std::exception  record or case cannot be read
  explicit FollowedRecord(const std::filesystem::path& folder);
  /// Reads on. @throws std::exception  the record cannot be read
  v1::CastingNow now();

private:
  std::mutex mutex_;
  jobs::ReadingsReader record_;
  levers::CastingProgress casting_;
};

/// The records of running jobs: no question reads one from its beginning again. Safe to use from
/// several threads.
class FollowedRecords {
public:
  /// @param folder  of the job  @param runs  whether a job still runs; others are forgotten
  /// @throws as FollowedRecord's constructor
  std::shared_ptr<FollowedRecord> open(const std::filesystem::path& folder,
                                       const std::function<bool(const std::string& job)>& runs);
  void forget(const std::string& job);

private:
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<FollowedRecord>> records_;
};

/// Everything that calls use; owned by the daemon.
struct Context {
  const v1::DaemonConfig& settings;  ///< as resolved by daemon::resolved()
  /// Jobs: queue, event logs and index.
  jobs::Scheduler& scheduler;
  jobs::EventLogs& logs;
  jobs::ReadingsLogs& readings;
  jobs::JobStore& store;
  studies::Studies& studies;
  studies::Lines& lines;
  /// Checks of cases, and files that cases name.
  const intake::CaseIntake& intake;
  intake::Uploads& uploads;
  Gate& gate;
  /// Processes that answer checks and queries, and which runs stop for others.
  jobs::WarmWorkers& warm_workers;
  jobs::Precedence& precedence;
  std::string solver;                     ///< identity of the workers' solver; empty if unknown
  std::string worker_sandbox;             ///< description of the workers' sandbox
  std::filesystem::path query_directory;  ///< parent of the folders of query runs
  std::filesystem::path jobs_directory;
  /// Of dccastd, as `dccastd --version` prints it.
  std::string version;
  int workers = 1;  ///< jobs that run concurrently
  jobs::StepIndexes step_indexes{};
  /// Answers of queries that left no job, bounded in bytes. Keys are fingerprints of
  /// their cases, by which CompareRuns names them.
  jobs::Recent<const QueryAnswer> query_answers{16'000'000};
  LatestWarnings latest_warnings{};
  FollowedRecords followed_records{};
  std::atomic<bool> leaving{false};  ///< the daemon is shutting down: streams end
};

}  // namespace dccast::service
