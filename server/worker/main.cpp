#include "server/worker/main.hpp"

#include <fcntl.h>
#include <google/protobuf/io/zero_copy_stream_impl.h>
#include <google/protobuf/util/delimited_message_util.h>
#include <signal.h>
#include <string.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <iostream>
#include <new>
#include <optional>
#include <string>
#include <system_error>

#include "core/casting/stored_run.hpp"
#include "core/storage/storage_error.hpp"
#include "server/jobs/job_folder.hpp"
#include "server/jobs/processes.hpp"
#include "server/jobs/worker_claim.hpp"
#include "server/worker/job_run.hpp"
#include "server/worker/memory_exhaustion.hpp"
#include "server/worker/run_job.hpp"
#include "server/worker/sandbox.hpp"

namespace dccast::worker {

namespace {

constexpr int exit_not_begun = 1;
constexpr int exit_usage = 2;
constexpr int exit_daemon_gone = 70;

int refuse_to_run_alone() {
  std::cerr << "dccast-worker is started by dccastd, see dccastd --help\n";
  return exit_usage;
}

/// A worker without a job, or without a claim on the folder of one, does not outlive its daemon:
/// the next one would not find it. Checkpoints are complete at any moment, so the kill costs no
/// more than some steps.
bool tie_to_parent(const std::string& parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  return std::to_string(::getppid()) == parent;  // else it died before the line above
}

/// A query must not wait for jobs: they get the processor that nothing else wants. 10 of the 19
/// steps leaves them a tenth of a core that a query wants too, so that no job stands still.
void step_back_behind_queries() {
  constexpr int steps_behind = 10;
  errno = 0;
  if (::nice(steps_behind) == -1 && errno != 0)
    std::cerr << "dccast-worker: runs at the priority of queries: " << ::strerror(errno) << '\n';
}

/// From now on the messages of this process belong to a job. A log that cannot be opened is no
/// reason not to run.
void write_messages_into(const std::filesystem::path& log) {
  const int file = ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  if (file < 0) return;
  ::dup2(file, STDOUT_FILENO);
  ::dup2(file, STDERR_FILENO);
  ::close(file);
}

/// The case of a job, as the daemon has completed it. @throws std::runtime_error
void read_case(v1::SolveCase& order) {
  const auto description = jobs::read_job_description(order.directory());
  if (!order.mutable_case_()->ParseFromString(description.complete_case))
    throw std::runtime_error(std::string("the case in ") + jobs::description_file +
                             " cannot be read");
}

v1::RunEnd unreadable_case(const std::exception& error) {
  v1::RunEnd end;
  end.set_outcome(v1::RunEnd::FAILED);
  end.mutable_failure()->set_kind(v1::Failure::STORAGE);
  end.mutable_failure()->set_message(std::string("the folder of the job is damaged: ") +
                                     error.what());
  return end;
}

/// A disk that is full is waited for; this is no more writable later.
v1::RunEnd too_large_a_file(std::int64_t most) {
  v1::RunEnd end;
  end.set_outcome(v1::RunEnd::FAILED);
  end.mutable_failure()->set_kind(v1::Failure::INVALID_CASE);
  end.mutable_failure()->set_message(
      "the case makes a file larger than " + storage::megabytes(most) +
      ": store fewer frames, or have worker_file raised in the settings of dccastd");
  return end;
}

v1::RunEnd end_of_run(v1::SolveCase& order, JobRun& run) {
  try {
    read_case(order);
  } catch (const std::system_error&) {
    throw;  // the disk
  } catch (const std::runtime_error& error) {
    return unreadable_case(error);
  }
  return run_job(order, run);
}

// Until a worker that was killed a moment ago gives up the folder; on another machine until it has
// seen that it is superseded, and the server of the files has forgotten its lock.
constexpr std::chrono::seconds longest_claim{5};
constexpr std::chrono::seconds longest_claim_elsewhere{120};

std::string isolation;  ///< what isolate() has reported

/// @throws jobs::FolderTaken, std::system_error
void run_in_folder(v1::SolveCase& order, std::optional<jobs::StartRank> rank) {
  const jobs::FolderClaim claim(order.directory(), {order.job_id(), order.attempt()},
                                rank ? longest_claim_elsewhere : longest_claim, rank);
  if (order.daemon_patience_s() > 0.0) ::prctl(PR_SET_PDEATHSIG, 0);  // the next daemon finds it
  std::cerr << "dccast-worker: " << isolation << ", " << confine_writing_to(order.directory())
            << ", "
            << bound({.memory_bytes = order.memory_bytes(), .file_bytes = order.file_bytes()})
            << std::endl;
  JobRun run(order, claim);
  v1::RunEnd end = end_of_run(order, run);
  if (end.outcome() == v1::RunEnd::FAILED && met_file_bound())
    end = too_large_a_file(order.file_bytes());
  end.set_attempt(order.attempt());
  end.set_solver(casting::solver_identity());
  run.end(std::move(end));
  ::_exit(0);  // nothing is left to do, and the next job waits for the end of this process
}

/// From now on this process runs a job and nothing else. @return its exit code
/// @param rank  of a worker that no daemon started
int run_whole_job(v1::SolveCase& order, std::optional<jobs::StartRank> rank = {}) {
  JobRun::prepare_signals();
  write_messages_into(std::filesystem::path(order.directory()) / "worker.log");
  try {
    run_in_folder(order, rank);
    return 0;
  } catch (const std::system_error& error) {
    std::cerr << "dccast-worker: " << error.what() << '\n';
    return storage::is_memory_fault(error.code()) ? jobs::exit_out_of_memory : jobs::exit_storage;
  }
}

/// The job whose order lies in a folder, on a machine that Slurm chose. What it does there does not
/// depend on a daemon.
int run_ordered(const std::string& folder, int attempt) {
  auto order = jobs::read_order(folder);
  if (!order || order->attempt() != attempt) {
    std::cerr << "dccast-worker: " << folder << " has no order for attempt " << attempt << '\n';
    return exit_not_begun;
  }
  ::prctl(PR_SET_NAME, "dccast-job");
  if (jobs::has_begun(folder, attempt)) {
    std::cerr << "dccast-worker: attempt " << attempt << " has begun before\n";
    return jobs::exit_begun_before;
  }
  order->set_directory(folder);
  return run_whole_job(*order, jobs::StartRank{.attempt = attempt});
}

/// What lists of processes show of a process at work.
const char* name_of(const v1::WorkerRequest& request) {
  if (request.has_solve()) return request.solve().job_id().empty() ? "dccast-query" : "dccast-job";
  return request.has_check() ? "dccast-check" : "dccast-read";
}

/// A worker of the daemon's own machine follows one that Slurm may not have ended yet.
std::optional<jobs::StartRank> rank_of(const v1::SolveCase& order) {
  const auto file = std::filesystem::path(order.directory()) / jobs::rank_file;
  if (::access(file.c_str(), F_OK) != 0) return std::nullopt;
  return jobs::StartRank{.attempt = order.attempt()};
}

/// Answers requests until the daemon closes the link, or one is the run of a job.
/// @param scratch  where files of answers are written
int serve_daemon(const std::filesystem::path& scratch) {
  google::protobuf::io::FileInputStream input(STDIN_FILENO);
  std::string confined;
  for (;;) {
    ::prctl(PR_SET_NAME, "dccast-worker");
    v1::WorkerRequest request;
    if (!google::protobuf::util::ParseDelimitedFromZeroCopyStream(&request, &input, nullptr))
      return 0;
    ::prctl(PR_SET_NAME, name_of(request));
    if (!request.solve().job_id().empty()) {
      v1::SolveCase& order = *request.mutable_solve();
      if (!order.goes_first()) step_back_behind_queries();
      return run_whole_job(order, rank_of(order));
    }
    // What an answer reads may take this process over: it never gets a job.
    if (confined.empty()) confined = confine_writing_to(scratch);
    v1::WorkerAnswer answered = answer(request, STDIN_FILENO);
    answered.set_sandbox(request.has_name_solver() ? isolation + ", " + confined : "");
    if (!send_answer(STDIN_FILENO, answered)) return exit_link_broken;
  }
}

}  // namespace

int main(int argc, char** argv) {
  ::signal(SIGPIPE, SIG_IGN);
  ::signal(SIGXFSZ, SIG_IGN);  // a file at its size limit is an error of write(), not our end
  name_memory_exhaustion();
  isolation = isolate();
  try {
    if (argc == 4 && argv[1] == std::string("--run"))
      return run_ordered(argv[2], std::atoi(argv[3]));
    const std::string parent = jobs::take_variable("DCCAST_WORKER_PARENT");
    if (parent.empty()) return refuse_to_run_alone();
    const std::string scratch = jobs::take_variable("DCCAST_WORKER_SCRATCH");
    return tie_to_parent(parent) ? serve_daemon(scratch) : exit_daemon_gone;
  } catch (const std::bad_alloc&) {
    std::cerr << "dccast-worker: out of memory\n";
    ::_exit(jobs::exit_out_of_memory);  // libraries that lacked memory may never end orderly
  } catch (const std::exception& error) {
    std::cerr << "dccast-worker: " << error.what() << '\n';
    return exit_not_begun;
  }
}

}  // namespace dccast::worker
