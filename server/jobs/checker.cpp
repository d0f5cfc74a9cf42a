#include "server/jobs/checker.hpp"

#include <poll.h>
#include <signal.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <optional>
#include <thread>
#include <utility>

#include "core/storage/storage_error.hpp"
#include "server/jobs/process.hpp"

namespace dccast::jobs {

namespace {

using Why = WorkerDidNotAnswer::Why;

// How often a checker at work is looked at: a call that was cancelled keeps it no longer than this.
constexpr int look_interval_ms = 20;
// A frame of the largest mesh that is permitted takes a tenth of this; more is no answer.
constexpr std::uint32_t largest_answer = 1u << 30;

/// Waits until a child that has closed its link is gone. A program may close that some time before
/// its end.
void let_it_end(pid_t process) {
  for (int i = 0; i < 100; ++i) {
    siginfo_t ended{};
    if (::waitid(P_PID, static_cast<id_t>(process), &ended, WEXITED | WNOWAIT | WNOHANG) != 0 ||
        ended.si_pid == process)
      return;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

/// Its end of the socket is the program's standard input; what libraries print goes to our log.
int spawn_checker(const std::filesystem::path& program, const std::string& option, int socket,
                  pid_t* process) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, socket, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO);
  const int error = spawn(program, {program, option}, worker_environment(), actions, process);
  posix_spawn_file_actions_destroy(&actions);
  return error;
}

[[noreturn]] void fail_to_start(const std::filesystem::path& program, int error) {
  throw WorkerDidNotAnswer(Why::not_started,
                           "cannot start " + program.string() + ": " + ::strerror(error));
}

}  // namespace

Checker::Checker(const std::filesystem::path& worker_program, const std::string& option,
                 std::int64_t largest_bytes)
    : name_(worker_program.filename().string() + " " + option), largest_bytes_(largest_bytes) {
  std::array<int, 2> ends;
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
    fail_to_start(worker_program, errno);
  socket_ = storage::FileDescriptor(ends[0]);
  const storage::FileDescriptor theirs(ends[1]);
  if (const int error = spawn_checker(worker_program, option, theirs.get(), &process_)) {
    process_ = 0;
    fail_to_start(worker_program, error);
  }
}

Checker::~Checker() {
  if (process_ == 0) return;
  ::kill(process_, SIGKILL);
  collect(process_, Waiting::until_its_end);
}

std::string Checker::ask(Question question, std::string_view text, const CallLimits& limits,
                         const OnPart& on_part) {
  const std::array<std::uint32_t, 2> head{static_cast<std::uint32_t>(question),
                                          static_cast<std::uint32_t>(text.size())};
  send({reinterpret_cast<const char*>(head.data()), sizeof head}, limits);
  send(text, limits);
  std::string answer;
  std::uint32_t kind = receive_piece(answer, limits);
  for (; kind == answer_part; kind = receive_piece(answer, limits)) on_part(answer);
  ++answers_;
  if (kind == answer_refused) throw WorkerDidNotAnswer(Why::refused, answer);
  return answer;
}

/// The next part of an answer, or its end. @return which
std::uint32_t Checker::receive_piece(std::string& text, const CallLimits& limits) {
  std::array<std::uint32_t, 2> head;
  text.resize(sizeof head);
  receive(text, limits);
  ::memcpy(head.data(), text.data(), sizeof head);
  if (head[0] > answer_part || head[1] > largest_answer)
    throw WorkerDidNotAnswer(Why::died, name_ + " sent an answer that cannot be read");
  text.resize(head[1]);
  receive(text, limits);
  return head[0];
}

bool Checker::waits() const {
  pollfd look{socket_.get(), POLLIN, 0};
  return ::poll(&look, 1, 0) == 0;  // it sends nothing unasked: anything readable is its end
}

std::int64_t Checker::resident_bytes() const {
  std::ifstream file("/proc/" + std::to_string(process_) + "/statm");
  std::int64_t all = 0, resident = 0;
  file >> all >> resident;
  return resident * ::sysconf(_SC_PAGESIZE);
}

void Checker::wait_until(short events, const CallLimits& limits) const {
  pollfd look{socket_.get(), events, 0};
  for (;;) {
    // Asked first: a worker whose parts come faster than this looks would never be called off.
    if (limits.called_off())
      throw WorkerDidNotAnswer(Why::called_off, "no one waits for this answer any more");
    if (std::chrono::steady_clock::now() > limits.deadline)
      throw WorkerDidNotAnswer(Why::too_slow, name_ + " took longer than it may");
    if (::poll(&look, 1, look_interval_ms) > 0) return;
    if (resident_bytes() > largest_bytes_)
      throw WorkerDidNotAnswer(Why::too_large,
                               name_ + " took more than " + storage::megabytes(largest_bytes_));
  }
}

void Checker::send(std::string_view bytes, const CallLimits& limits) {
  while (!bytes.empty()) {
    const auto sent =
        ::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent >= 0)
      bytes.remove_prefix(static_cast<std::size_t>(sent));
    else if (errno == EAGAIN)
      wait_until(POLLOUT, limits);
    else if (errno != EINTR)
      report_death();
  }
}

void Checker::receive(std::string& bytes, const CallLimits& limits) {
  std::size_t received = 0;
  while (received < bytes.size()) {
    const auto size =
        ::recv(socket_.get(), bytes.data() + received, bytes.size() - received, MSG_DONTWAIT);
    if (size > 0)
      received += static_cast<std::size_t>(size);
    else if (size < 0 && errno == EAGAIN)
      wait_until(POLLIN, limits);
    else if (size == 0 || errno != EINTR)
      report_death();
  }
}

void Checker::report_death() {
  let_it_end(process_);
  ::kill(process_, SIGKILL);
  const auto status = collect(std::exchange(process_, 0), Waiting::until_its_end).status;
  if (!status) throw WorkerDidNotAnswer(Why::died, name_ + " has ended, how is not known");
  const bool by_signal = WIFSIGNALED(*status);
  const bool killed = by_signal && (WTERMSIG(*status) == SIGKILL || WTERMSIG(*status) == SIGTERM);
  throw WorkerDidNotAnswer(killed ? Why::killed : Why::died,
                           name_ + " ended with " + describe_exit(*status));
}

CheckerPool::CheckerPool(std::filesystem::path worker_program, CheckerLimits limits)
    : worker_program_(std::move(worker_program)), limits_(std::move(limits)) {}

void CheckerPool::warm_up() {
  for (int i = 0; i < limits_.kept; ++i) give_back(start());
}

std::string CheckerPool::ask(Question question, std::string_view text, const CallLimits& limits,
                             const OnPart& on_part) {
  auto checker = take();
  try {
    std::string answer = checker->ask(question, text, limits, on_part);
    give_back(std::move(checker));
    return answer;
  } catch (const WorkerDidNotAnswer& error) {
    if (error.why() == WorkerDidNotAnswer::Why::refused) {
      give_back(std::move(checker));
    } else {
      checker.reset();  // first: two at once may be one too many for the memory
      replace();
    }
    throw;
  }
}

/// Starts one more, if fewer than are kept wait. One that cannot be started now is tried again when
/// it is needed, and reported then.
void CheckerPool::replace() noexcept {
  try {
    {
      const std::lock_guard lock(mutex_);
      if (static_cast<int>(idle_.size()) >= limits_.kept) return;
    }
    keep(start());
  } catch (const std::exception&) {
  }
}

std::unique_ptr<Checker> CheckerPool::start() const {
  return std::make_unique<Checker>(worker_program_, limits_.option, limits_.largest_bytes);
}

std::unique_ptr<Checker> CheckerPool::take() {
  for (;;) {
    std::unique_ptr<Checker> checker;
    {
      const std::lock_guard lock(mutex_);
      if (idle_.empty()) break;
      checker = std::move(idle_.back());
      idle_.pop_back();
    }
    if (checker->waits()) return checker;
  }
  return start();
}

void CheckerPool::give_back(std::unique_ptr<Checker> checker) {
  const bool worn =
      checker->answers() >= limits_.answers || checker->resident_bytes() > limits_.idle_bytes;
  if (!worn) return keep(std::move(checker));
  checker.reset();
  replace();
}

void CheckerPool::keep(std::unique_ptr<Checker> checker) {
  const std::lock_guard lock(mutex_);
  if (static_cast<int>(idle_.size()) < limits_.kept) idle_.push_back(std::move(checker));
}

}  // namespace dccast::jobs
