#include "server/worker/main.hpp"

#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <iostream>
#include <new>
#include <optional>
#include <string>
#include <system_error>

#include "core/casting/stored_run.hpp"
#include "server/jobs/job_folder.hpp"
#include "server/jobs/worker_claim.hpp"
#include "server/worker/job_run.hpp"
#include "server/worker/memory_exhaustion.hpp"
#include "server/worker/run_job.hpp"

namespace dccast::worker {

namespace {

constexpr int exit_not_answered = 1;
constexpr int exit_usage = 2;
constexpr int exit_daemon_gone = 70;

std::string take_variable(const char* name) {
  const char* value = ::getenv(name);
  std::string text = value == nullptr ? "" : value;
  ::unsetenv(name);
  return text;
}

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

/// Waits for the job on the standard input: the length of the order, 4 bytes in the machine's
/// order, then the order. @return nothing when the daemon has closed it without a job
std::optional<v1::WorkerOrder> wait_for_order() {
  std::uint32_t length = 0;
  v1::WorkerOrder order;
  if (!std::cin.read(reinterpret_cast<char*>(&length), sizeof length)) return std::nullopt;
  std::string bytes(length, '\0');
  if (!std::cin.read(bytes.data(), length) || !order.ParseFromString(bytes)) return std::nullopt;
  return order;
}

/// The case of a job, as the daemon has completed it. @throws std::runtime_error
void read_case(v1::WorkerOrder& order) {
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

v1::RunEnd end_of_run(v1::WorkerOrder& order, JobRun& run) {
  try {
    read_case(order);
  } catch (const std::system_error&) {
    throw;  // the disk
  } catch (const std::runtime_error& error) {
    return unreadable_case(error);
  }
  return run_job(order, run);
}

/// @throws jobs::FolderTaken, std::system_error
void run_in_folder(v1::WorkerOrder& order) {
  constexpr std::chrono::seconds longest{5};  // for a worker that was killed a moment ago
  const jobs::FolderClaim claim(order.directory(), {order.job_id(), order.attempt()}, longest);
  if (order.daemon_patience_s() > 0.0) ::prctl(PR_SET_PDEATHSIG, 0);  // the next daemon finds it
  JobRun run(order, claim);
  v1::RunEnd end = end_of_run(order, run);
  end.set_attempt(order.attempt());
  end.set_solver(casting::solver_identity());
  run.end(std::move(end));
  ::_exit(0);  // nothing is left to do, and the next job waits for the end of this process
}

bool answers_questions(const char* option) {
  return ::strcmp(option, "--serve-checks") == 0 || ::strcmp(option, "--serve-queries") == 0;
}

int run_job_of_daemon() {
  const std::string parent = take_variable("DCCAST_WORKER_PARENT");
  if (parent.empty()) return refuse_to_run_alone();
  if (!tie_to_parent(parent)) return exit_daemon_gone;
  step_back_behind_queries();
  JobRun::prepare_signals();
  auto order = wait_for_order();
  if (!order) return 0;
  write_messages_into(std::filesystem::path(order->directory()) / "worker.log");
  try {
    run_in_folder(*order);
    return 0;
  } catch (const std::system_error& error) {
    std::cerr << "dccast-worker: " << error.what() << '\n';
    return jobs::is_memory_fault(error.code()) ? jobs::exit_out_of_memory : jobs::exit_storage;
  }
}

}  // namespace

int main(int argc, char** argv) {
  ::signal(SIGPIPE, SIG_IGN);
  ::signal(SIGXFSZ, SIG_IGN);  // a file at its size limit is an error of write(), not our end
  name_memory_exhaustion();
  try {
    if (argc == 2 && answers_questions(argv[1])) {
      // A closed socket ends it between two questions, this one that never ends.
      ::prctl(PR_SET_PDEATHSIG, SIGKILL);
      return serve_checks(STDIN_FILENO);
    }
    if (argc == 2 && ::strcmp(argv[1], "--wait") == 0) return run_job_of_daemon();
    return refuse_to_run_alone();
  } catch (const std::bad_alloc&) {
    std::cerr << "dccast-worker: out of memory\n";
    return jobs::exit_out_of_memory;
  } catch (const std::exception& error) {
    std::cerr << "dccast-worker: " << error.what() << '\n';
    return exit_not_answered;
  }
}

}  // namespace dccast::worker
