#include "server/worker/main.hpp"

#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <exception>
#include <iostream>
#include <new>
#include <optional>
#include <string>
#include <system_error>

#include "core/casting/solver_identity.hpp"
#include "server/jobs/worker_claim.hpp"
#include "server/jobs/worker_exit.hpp"
#include "server/worker/answers.hpp"
#include "server/worker/link_client.hpp"
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

/// From now on what this process says belongs to a job. A log that cannot be opened is no reason
/// not to run: what matters goes over the link.
void speak_into(const std::string& log) {
  const int file = ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  if (file < 0) return;
  ::dup2(file, STDOUT_FILENO);
  ::dup2(file, STDERR_FILENO);
  ::close(file);
}

/// Waits for the job on the standard input: its id, the token, the file for what is said; a line
/// each. @return nothing when the daemon has closed it without a job
std::optional<v1::WorkerMessage::Hello> wait_for_job() {
  v1::WorkerMessage::Hello hello;
  std::string log;
  if (!std::getline(std::cin, *hello.mutable_job_id()) ||
      !std::getline(std::cin, *hello.mutable_token()) || !std::getline(std::cin, log))
    return std::nullopt;
  hello.set_process_id(::getpid());
  hello.set_protocol(jobs::worker_protocol);
  hello.set_solver(casting::solver_identity());
  speak_into(log);
  return hello;
}

/// Claims the folder of the job and, where the daemon asks for it, outlives the daemon from then
/// on. Where the claim cannot be written the worker dies with its daemon, as one without a job
/// does.
/// @param claim  is empty; lives as long as the link
/// @throws jobs::FolderTaken
void settle_in(const std::string& job_id, const v1::WorkerOrder::Start& start, LinkClient& link,
               std::optional<jobs::FolderClaim>& claim) {
  constexpr std::chrono::seconds longest{5};  // for a worker that was killed a moment ago
  try {
    claim.emplace(start.directory(), jobs::WorkerClaim{job_id, start.attempt()}, longest);
  } catch (const std::system_error& error) {
    std::cerr << "dccast-worker: ends with its dccastd: " << error.what() << std::endl;
    return;
  }
  if (start.daemon_patience_s() <= 0.0) return;
  const std::chrono::duration<double> patience(start.daemon_patience_s());
  link.outlive_daemon(std::chrono::duration_cast<LinkClient::Clock::duration>(patience),
                      [&claim] { return claim->stands(); });
  ::prctl(PR_SET_PDEATHSIG, 0);
}

bool answers_questions(const char* option) {
  return ::strcmp(option, "--serve-checks") == 0 || ::strcmp(option, "--serve-queries") == 0;
}

int run_job_of_daemon() {
  const std::string address = take_variable("DCCAST_WORKER_LINK");
  const std::string parent = take_variable("DCCAST_WORKER_PARENT");
  if (address.empty()) return refuse_to_run_alone();
  if (!tie_to_parent(parent)) return exit_daemon_gone;
  step_back_behind_queries();
  std::optional<jobs::FolderClaim> claim;
  LinkClient link(address);  // before there is a job: the library takes its time
  const auto hello = wait_for_job();
  if (!hello) return 0;
  const auto start = link.begin(*hello);
  if (!start) return exit_daemon_gone;
  settle_in(hello->job_id(), *start, link, claim);
  if (!link.finish(run_job(*start, link))) return exit_daemon_gone;
  // The daemon has everything. Taking gRPC down in good order only keeps the next job waiting: half
  // of the 9 ms between two jobs.
  ::_exit(0);
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
