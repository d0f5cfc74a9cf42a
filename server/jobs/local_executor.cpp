#include "server/jobs/local_executor.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <system_error>
#include <vector>

#include "server/jobs/spawn.hpp"

namespace dccast::jobs {

namespace {

std::vector<std::string> job_environment(const WorkerLaunch& launch, const std::string& link) {
  std::vector<std::string> variables = worker_environment();
  variables.insert(variables.end(),
                   {"DCCAST_WORKER_LINK=" + link, "DCCAST_WORKER_JOB=" + launch.job_id,
                    "DCCAST_WORKER_TOKEN=" + launch.token,
                    "DCCAST_WORKER_PARENT=" + std::to_string(::getpid())});
  return variables;
}

/// A worker has nothing to read, and a log of its own for what it says. @return 0 or an error
/// number
int spawn_worker(const std::filesystem::path& program, const WorkerLaunch& launch,
                 const std::string& link, pid_t* process) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  const std::string log = launch.folder / "worker.log";
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log.c_str(),
                                   O_WRONLY | O_CREAT | O_APPEND, 0600);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  const int error = spawn(program, {program}, job_environment(launch, link), actions, process);
  posix_spawn_file_actions_destroy(&actions);
  return error;
}

}  // namespace

LocalExecutor::LocalExecutor(std::filesystem::path worker_program, std::string link_address)
    : worker_program_(std::move(worker_program)),
      link_address_(std::move(link_address)),
      wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (!wake_) throw std::system_error(errno, std::generic_category(), "eventfd");
  thread_ = std::thread([this] { run(); });
}

LocalExecutor::~LocalExecutor() {
  post([this] { stopping_ = true; });
  thread_.join();
}

void LocalExecutor::post(std::function<void()> order) {
  {
    const std::lock_guard lock(mutex_);
    orders_.push_back(std::move(order));
  }
  ::eventfd_write(wake_.get(), 1);
}

void LocalExecutor::start(const WorkerLaunch& launch) {
  post([this, launch] { spawn(launch); });
}

void LocalExecutor::kill(const std::string& job_id, int attempt) {
  post([this, key = std::pair(job_id, attempt)] {
    if (const auto found = children_.find(key); found != children_.end())
      ::kill(found->second.process, SIGKILL);  // ours and not collected: the id is still its own
  });
}

void LocalExecutor::spawn(const WorkerLaunch& launch) {
  pid_t process = 0;
  if (const int error = spawn_worker(worker_program_, launch, link_address_, &process)) {
    calls_.ended(launch.job_id, launch.attempt,
                 "cannot start " + worker_program_.string() + ": " + ::strerror(error));
    return;
  }
  // glibc 2.36 declares pidfd_open() without C linkage; the system call has no such fault.
  FileDescriptor handle(static_cast<int>(::syscall(SYS_pidfd_open, process, 0)));
  const auto identity = identify(process);  // not collected yet: it is there, if only as a zombie
  children_[{launch.job_id, launch.attempt}] = {launch, process, std::move(handle)};
  calls_.started(launch.job_id, launch.attempt, identity.value_or(ProcessIdentity{process, 0}));
}

void LocalExecutor::wait_for_something() {
  std::vector<pollfd> waiting{{wake_.get(), POLLIN, 0}};
  int timeout_ms = -1;
  for (const auto& [key, child] : children_) {
    waiting.push_back({child.handle.get(), POLLIN, 0});
    if (!child.handle) timeout_ms = 20;  // a kernel or a container without pidfd_open: look often
  }
  ::poll(waiting.data(), waiting.size(), timeout_ms);
}

void LocalExecutor::collect() {
  for (auto at = children_.begin(); at != children_.end();) {
    int status = 0;
    if (::waitpid(at->second.process, &status, WNOHANG) != at->second.process) {
      ++at;
      continue;
    }
    const WorkerLaunch launch = at->second.launch;
    at = children_.erase(at);
    calls_.ended(launch.job_id, launch.attempt, describe_exit(status));
  }
}

void LocalExecutor::run() {
  for (;;) {
    wait_for_something();
    eventfd_t count;
    ::eventfd_read(wake_.get(), &count);
    std::deque<std::function<void()>> orders;
    {
      const std::lock_guard lock(mutex_);
      orders.swap(orders_);
    }
    for (const auto& order : orders) order();
    collect();
    if (!stopping_) continue;
    for (const auto& [key, child] : children_) {
      ::kill(child.process, SIGKILL);
      ::waitpid(child.process, nullptr, 0);
    }
    return;
  }
}

}  // namespace dccast::jobs
