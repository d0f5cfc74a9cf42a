#include "server/jobs/local_executor.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/eventfd.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <memory>
#include <system_error>
#include <vector>

#include "server/jobs/log.hpp"
#include "server/jobs/process.hpp"

namespace dccast::jobs {

namespace {

using storage::FileDescriptor;

std::vector<std::string> job_environment() {
  std::vector<std::string> variables = worker_environment();
  variables.push_back("DCCAST_WORKER_PARENT=" + std::to_string(::getpid()));
  return variables;
}

[[noreturn]] void fail(const std::string& what, int error) {
  throw std::system_error(error, std::generic_category(), what);
}

/// @return read end, write end; both closed in children that are not given them
std::pair<FileDescriptor, FileDescriptor> make_pipe() {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) fail("cannot make a pipe to a worker", errno);
  return {FileDescriptor(ends[0]), FileDescriptor(ends[1])};
}

/// Who claims the folder of a job; nothing where that cannot be found out.
std::optional<ClaimHolder> claim_on(const WorkerLaunch& launch) {
  try {
    return holder_of(launch.folder);
  } catch (const std::exception& error) {
    log::error("job {}: {}", launch.job_id, error.what());
    return std::nullopt;
  }
}

/// Whether a process has ended, within this time. @param handle  pidfd
bool has_ended(const FileDescriptor& handle, int longest_ms) {
  pollfd waiting{handle.get(), POLLIN, 0};
  return ::poll(&waiting, 1, longest_ms) > 0;
}

/// To the process of a pidfd, whatever its parent is.
void send_to(const FileDescriptor& handle, int number) {
  ::syscall(SYS_pidfd_send_signal, handle.get(), number, nullptr, 0);
}

void kill_and_wait(const FileDescriptor& handle) {
  constexpr int longest_ms = 5000;
  send_to(handle, SIGKILL);
  if (!has_ended(handle, longest_ms)) log::error("a worker that was killed does not end");
}

/// What a worker reads on its standard input: see wait_for_order() of the worker.
std::string framed(const std::string& order) {
  const auto length = static_cast<std::uint32_t>(order.size());
  return std::string(reinterpret_cast<const char*>(&length), sizeof length) + order;
}

bool may_lead(const ClaimHolder& holder, const WorkerLaunch& launch) {
  return holder.claim && holder.claim->protocol == worker_protocol &&
         holder.claim->job_id == launch.job_id && holder.claim->attempt == launch.attempt;
}

}  // namespace

LocalExecutor::LocalExecutor(std::filesystem::path worker_program, int capacity)
    : worker_program_(std::move(worker_program)),
      capacity_(capacity),
      wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (!wake_) fail("eventfd", errno);
  thread_ = std::thread([this] { run(); });
}

LocalExecutor::~LocalExecutor() {
  end_thread();
}

void LocalExecutor::end_thread() {
  if (!thread_.joinable()) return;
  post([this] { stopping_ = true; });
  thread_.join();
}

void LocalExecutor::let_workers_run() {
  post([this] { leaves_workers_ = true; });
  end_thread();
}

void LocalExecutor::post(std::function<void()> order) {
  {
    const std::lock_guard lock(mutex_);
    orders_.push_back(std::move(order));
  }
  ::eventfd_write(wake_.get(), 1);
}

void LocalExecutor::start(const WorkerLaunch& launch) {
  post([this, launch] { hand_over(launch); });
}

void LocalExecutor::stop(const std::string& job_id, int attempt) {
  send_signal(job_id, attempt, SIGTERM);
}

void LocalExecutor::kill(const std::string& job_id, int attempt) {
  send_signal(job_id, attempt, SIGKILL);
}

void LocalExecutor::send_signal(const std::string& job_id, int attempt, int number) {
  post([this, key = std::pair(job_id, attempt), number] {
    if (const auto found = children_.find(key); found != children_.end())
      send_signal(found->second, number);
  });
}

Adoption LocalExecutor::adopt(const WorkerLaunch& launch, bool wanted) {
  auto holder = claim_on(launch);
  if (!holder) return Adoption::gone;
  if (wanted && may_lead(*holder, launch)) {
    auto found = std::make_shared<Child>();
    found->process = holder->process;
    found->handle = std::move(holder->handle);
    found->adopted = true;
    post([this, found, key = std::pair(launch.job_id, launch.attempt)] {
      children_[key] = std::move(*found);
    });
    return Adoption::found;
  }
  log::warn("job {}: a worker that cannot be led on is ended (process {})", launch.job_id,
            holder->process);
  kill_and_wait(holder->handle);
  return Adoption::gone;
}

LocalExecutor::Child LocalExecutor::spawn() const {
  auto [read_end, write_end] = make_pipe();
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, read_end.get(), STDIN_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  Child child;
  const int error = jobs::spawn(worker_program_, {worker_program_, "--wait"}, job_environment(),
                                actions, &child.process);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) fail("cannot start " + worker_program_.string(), error);
  child.orders = std::move(write_end);
  child.handle = open_process(child.process);
  return child;
}

void LocalExecutor::hand_over(const WorkerLaunch& launch) {
  used_ = true;
  try {
    Child child = ready_ ? std::move(*ready_) : spawn();
    ready_.reset();
    const std::string order = framed(launch.order);
    // One that died while it waited is found by collect().
    if (::write(child.orders.get(), order.data(), order.size()) < 0 && errno != EPIPE)
      log::warn("job {}: cannot hand a worker its job: {}", launch.job_id,
                std::generic_category().message(errno));
    child.orders = FileDescriptor();
    children_[{launch.job_id, launch.attempt}] = std::move(child);
  } catch (const std::exception& error) {
    calls_.not_started(launch.job_id, launch.attempt, error.what());
  }
}

/// One that dies while it waits is replaced with the next job only: it may well die again.
void LocalExecutor::keep_one_ready() {
  if (ready_) {
    if (!jobs::collect(ready_->process, Waiting::not_at_all).running) ready_.reset();
    return;
  }
  if (!used_) return;
  used_ = false;
  try {
    ready_ = spawn();
  } catch (const std::exception& error) {
    log::debug("no worker is kept ready: {}", error.what());
  }
}

void LocalExecutor::wait_for_something() {
  std::vector<pollfd> waiting{{wake_.get(), POLLIN, 0}};
  int timeout_ms = -1;
  const auto watch = [&](const Child& child) {
    waiting.push_back({child.handle.get(), POLLIN, 0});
    if (!child.handle) timeout_ms = 20;  // a kernel or a container without pidfd_open: look often
  };
  for (const auto& [key, child] : children_) watch(child);
  if (ready_) watch(*ready_);
  ::poll(waiting.data(), waiting.size(), timeout_ms);
}

void LocalExecutor::collect() {
  for (auto at = children_.begin(); at != children_.end();) {
    const auto exit = exit_of(at->second);
    if (!exit) {
      ++at;
      continue;
    }
    const auto [job_id, attempt] = at->first;
    at = children_.erase(at);
    calls_.ended(job_id, attempt, *exit);
  }
}

/// How a process has ended; nothing while it runs.
std::optional<WorkerExit> LocalExecutor::exit_of(const Child& child) {
  static const WorkerExit unknown{"an unknown exit code"};
  if (child.adopted) return has_ended(child.handle, 0) ? std::optional(unknown) : std::nullopt;
  const ChildState state = jobs::collect(child.process, Waiting::not_at_all);
  if (state.running) return std::nullopt;
  if (!state.status) return unknown;
  WorkerExit exit{describe_exit(*state.status)};
  if (WIFEXITED(*state.status)) exit.code = WEXITSTATUS(*state.status);
  return exit;
}

void LocalExecutor::send_signal(const Child& child, int number) {
  if (child.adopted)
    send_to(child.handle, number);
  else
    ::kill(child.process, number);  // ours and not collected: the id is still its own
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
    if (stopping_) break;
    keep_one_ready();
  }
  // Those that have claimed no folder get the signal of their parent's death now.
  if (leaves_workers_) children_.clear();
  if (ready_) children_[{"", 0}] = std::move(*ready_);
  for (const auto& [key, child] : children_) {
    if (child.adopted) continue;
    send_signal(child, SIGKILL);
    jobs::collect(child.process, Waiting::until_its_end);
  }
}

}  // namespace dccast::jobs
