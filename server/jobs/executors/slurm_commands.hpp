#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace dccast::jobs {

/// A command of Slurm failed, or its controller refused the request.
struct SlurmError : std::runtime_error {
  SlurmError(const std::string& what, bool is_refusal)
      : std::runtime_error(what), refused(is_refusal) {}
  bool refused;  ///< true: the controller rejected the request; false: it may have carried it out
};

/// Identity of a worker's start, from which its job name in Slurm is made. The numbers of Slurm
/// jobs are no key: a number that is lost in a crash of slurmctld is given to the next job.
struct SlurmName {
  /// Job and attempt, which name the job in Slurm.
  std::string job_id;
  int attempt = 0;
};
/// As Slurm shows it: "dccast-ID.ATTEMPT".
std::string to_string(const SlurmName& name);

/// State of one start in Slurm.
struct SlurmJob {
  SlurmName name;
  std::string state;    ///< "PENDING", "RUNNING", "COMPLETED", "TIMEOUT", ...
  std::string reason;   ///< why it waits or has ended: "Resources", "Priority", "NonZeroExitCode"
  int exit_status = 0;  ///< as returned by waitpid()

  /// Whether it is in a final state of Slurm.
  bool ended() const;
  /// Whether it has processors, or had them a moment ago.
  bool runs() const;
};
using SlurmJobs = std::multimap<std::string, SlurmJob>;  ///< by job id

/// Settings of the daemon for Slurm.
struct SlurmOptions {
  std::filesystem::path jobs_directory;         ///< the same path on all nodes
  std::filesystem::path worker_program;         ///< the same path on all nodes
  int jobs = 200;                               ///< number of jobs submitted to Slurm at once
  std::vector<std::string> options{};           ///< further options of sbatch
  std::chrono::seconds time_limit{0};           ///< 0: limit of the partition
  std::chrono::seconds checkpoint_before{120};  ///< SIGTERM is sent so long before the time limit
  double memory_bytes = 0.0;                    ///< 0: default of the partition
  std::chrono::milliseconds interval{3000};     ///< polling interval for all jobs
  std::chrono::milliseconds unsure{10000};      ///< after which an unconfirmed submission is absent
  std::chrono::milliseconds silence{15000};     ///< after which a folder has no writing worker
  std::chrono::milliseconds visibility{90000};  ///< until files written by a node are seen here
};

// The commands of Slurm, found in PATH. Each takes some 10 ms, or 10 s if no controller answers.
// @throws SlurmError

/// All starts of this user that Slurm knows, including those that have just ended, in one request.
/// Reads the text format, because fields of the JSON format have changed their type between
/// versions.
SlurmJobs slurm_jobs();
/// Submits with sbatch. @throws std::runtime_error  Slurm's reason
/// @param cores  processors for the job
void slurm_submit(const SlurmName& name, const std::filesystem::path& folder, int cores,
                  const SlurmOptions& options);
/// Cancels all jobs of this name with scancel.
void slurm_cancel(const SlurmName& name);
/// Sends SIGTERM to the worker, which stops at a checkpoint.
void slurm_terminate(const SlurmName& name);

}  // namespace dccast::jobs
