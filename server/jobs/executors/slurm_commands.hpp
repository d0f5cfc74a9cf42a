#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace dccast::jobs {

/// A command of Slurm gave no answer, or a refusal.
struct SlurmError : std::runtime_error {
  SlurmError(const std::string& what, bool is_refusal)
      : std::runtime_error(what), refused(is_refusal) {}
  bool refused;  ///< the controller has looked at the request and will not do it; else it may have
};

/// The start of a job's worker, by the name it has in Slurm. The numbers that Slurm gives to jobs
/// are no key: one that is lost in a crash of slurmctld is given to the next job.
struct SlurmName {
  std::string job_id;
  int attempt = 0;
};
std::string text_of(const SlurmName& name);

/// What Slurm shows of one start.
struct SlurmJob {
  SlurmName name;
  std::string state;    ///< "PENDING", "RUNNING", "COMPLETED", "TIMEOUT", ...
  std::string reason;   ///< why it waits or has ended: "Resources", "Priority", "NonZeroExitCode"
  int exit_status = 0;  ///< as of waitpid()

  /// Slurm is done with it.
  bool ended() const;
  /// It has processors, or had them a moment ago.
  bool runs() const;
};
using SlurmJobs = std::multimap<std::string, SlurmJob>;  ///< by job id

struct SlurmOptions {
  std::filesystem::path jobs_directory;  ///< the same path on all nodes
  std::filesystem::path worker_program;  ///< the same
  int jobs = 200;                        ///< handed to Slurm at once
  std::vector<std::string> options{};    ///< of sbatch
  std::chrono::seconds time_limit{0};    ///< 0: of the partition
  std::chrono::seconds checkpoint_before{120};
  double memory_bytes = 0.0;                    ///< 0: of the partition
  std::chrono::milliseconds interval{3000};     ///< from one question for all jobs to the next
  std::chrono::milliseconds unsure{10000};      ///< until a submission without an answer is absent
  std::chrono::milliseconds silence{15000};     ///< after which no worker writes into a folder
  std::chrono::milliseconds visibility{90000};  ///< until what a node has written is seen here
};

// The commands of Slurm, as they are found in PATH. Each takes some 10 ms, or 10 s when no
// controller answers. @throws SlurmError

/// All starts of this user that Slurm knows, those that have just ended too, in one request. The
/// text form, because fields of the JSON form have changed their type between versions.
SlurmJobs slurm_jobs();
void slurm_submit(const SlurmName& name, const std::filesystem::path& folder, int cores,
                  const SlurmOptions& options);
void slurm_cancel(const SlurmName& name);
/// SIGTERM to the worker: it stops at a checkpoint.
void slurm_terminate(const SlurmName& name);

}  // namespace dccast::jobs
