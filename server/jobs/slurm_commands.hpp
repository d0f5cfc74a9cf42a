#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace dccast::jobs {

/// A command of Slurm gave no answer, or a refusal.
class SlurmError : public std::runtime_error {
public:
  SlurmError(const std::string& what, bool refused) : std::runtime_error(what), refused_(refused) {}
  /// The controller has looked at the request and will not do it. Else it may have been done.
  bool refused() const { return refused_; }

private:
  bool refused_;
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

struct SlurmSubmission {
  SlurmName name;
  std::filesystem::path folder;  ///< of the job
  std::filesystem::path worker_program;
  int cores = 1;
  std::chrono::seconds time_limit{0};  ///< 0: of the partition
  std::chrono::seconds checkpoint_before{120};
  double memory_bytes = 0.0;  ///< 0: of the partition
  std::vector<std::string> options{};
};

// The commands of Slurm, as they are found in PATH. Each takes some 10 ms, or 10 s when no
// controller answers. @throws SlurmError

/// All starts of this user that Slurm knows, those that have just ended too, in one request. The
/// text form, because fields of the JSON form have changed their type between versions.
SlurmJobs slurm_jobs();
void slurm_submit(const SlurmSubmission& submission);
void slurm_cancel(const SlurmName& name);
/// SIGTERM to the worker: it stops at a checkpoint.
void slurm_terminate(const SlurmName& name);

}  // namespace dccast::jobs
