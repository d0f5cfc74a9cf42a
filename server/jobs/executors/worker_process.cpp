#include "server/jobs/executors/worker_process.hpp"

#include <fmt/core.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/util/delimited_message_util.h>
#include <poll.h>
#include <signal.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <sstream>
#include <thread>
#include <utility>
#include <vector>

#include "core/storage/storage_error.hpp"
#include "server/jobs/log.hpp"

namespace dccast::jobs {

namespace {

using Why = WorkerDidNotAnswer::Why;

// Polling interval of a busy worker: a cancelled call frees it after this time at the latest.
constexpr int poll_interval_ms = 20;
// A frame of the largest permitted mesh takes a tenth of this.
constexpr std::uint32_t largest_answer = 1u << 30;
constexpr std::size_t longest_varint = 10;

/// Waits for the end of a child that has closed its socket, for 1 s at most: a program closes it
/// some time before its end.
void wait_for_end(pid_t process) {
  for (int i = 0; i < 100; ++i) {
    siginfo_t ended{};
    if (::waitid(P_PID, static_cast<id_t>(process), &ended, WEXITED | WNOWAIT | WNOHANG) != 0 ||
        ended.si_pid == process)
      return;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

/// Collects a child. @param options  of waitpid()
/// @return its id, 0 while it runs, -1 if it is not our child
pid_t collect(pid_t child, int options, int& status) {
  pid_t collected;
  do collected = ::waitpid(child, &status, options);
  while (collected < 0 && errno == EINTR);
  return collected;
}

/// Environment of a worker: that of the daemon without the variables of workers, and with one
/// thread for BLAS. Jobs share the cores, and measurements showed no gain of the solver from two
/// threads.
std::vector<std::string> worker_environment() {
  auto variables = environment(
      false, {"DCCAST_WORKER_", "OPENBLAS_NUM_THREADS=", "OMP_NUM_THREADS=", "OMP_THREAD_LIMIT="});

  // CHOLMOD's supernodal code sets its number of threads regardless of OMP_NUM_THREADS, but
  // respects OMP_THREAD_LIMIT.
  variables.insert(variables.end(),
                   {"OPENBLAS_NUM_THREADS=1", "OMP_NUM_THREADS=1", "OMP_THREAD_LIMIT=1",
                    fmt::format("DCCAST_WORKER_PARENT={}", ::getpid())});
  return variables;
}

[[noreturn]] void fail_to_start(const std::filesystem::path& program, int error) {
  throw WorkerDidNotAnswer(Why::not_started,
                           fmt::format("cannot start {}: {}", program.string(), ::strerror(error)));
}

}  // namespace

std::string folder_of(const v1::WorkerRequest& request) {
  switch (request.request_case()) {
    case v1::WorkerRequest::kReadFrame:
      return request.read_frame().directory();
    case v1::WorkerRequest::kProbeFrames:
      return request.probe_frames().directory();
    case v1::WorkerRequest::kCheck:
      return request.check().directory();
    case v1::WorkerRequest::kSolve:
      return request.solve().directory();
    case v1::WorkerRequest::kWriteTable:
      return std::filesystem::path(request.write_table().path()).parent_path();
    default:
      return {};
  }
}

WorkerProcess::WorkerProcess(const std::filesystem::path& program)
    : name_(program.filename().string()) {
  std::array<int, 2> ends;
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
    fail_to_start(program, errno);
  socket_ = storage::FileDescriptor(ends[0]);
  const storage::FileDescriptor theirs(ends[1]);

  // The socket is the worker's standard input. Output of its libraries goes to the daemon's log.
  if (const int error = spawn({program}, worker_environment(),
                              {theirs.get(), STDERR_FILENO, STDERR_FILENO}, &process_)) {
    process_ = 0;
    fail_to_start(program, error);
  }
  id_ = process_;
  handle_ = open_process(process_);
}

WorkerProcess::~WorkerProcess() {
  if (process_ == 0) return;
  ::kill(process_, SIGKILL);
  int status = 0;
  collect(process_, 0, status);
}

v1::WorkerAnswer WorkerProcess::ask(const v1::WorkerRequest& request, const CallLimits& limits,
                                    const OnEvent& on_event) {
  if (answers_ == 0) folder_ = folder_of(request);
  send(request, limits);
  for (;;) {
    v1::WorkerAnswer answer = receive(limits);
    if (answer.has_event()) {
      on_event(*answer.mutable_event());
      continue;
    }
    ++answers_;
    return answer;
  }
}

void WorkerProcess::hand_over(const v1::SolveCase& job) {
  constexpr std::chrono::seconds longest{1};  // the socket's buffer holds the whole request
  v1::WorkerRequest request;
  *request.mutable_solve() = job;
  try {
    send(request, {.deadline = std::chrono::steady_clock::now() + longest});
  } catch (const WorkerDidNotAnswer& error) {
    log::warn("job {}: cannot hand a worker its job: {}", job.job_id(), error.what());
  }
  socket_ = {};
}

void WorkerProcess::signal(int number) const {
  if (process_ != 0)
    ::kill(process_, number);  // ours and not collected: the id is still its own
  else
    ::syscall(SYS_pidfd_send_signal, handle_.get(), number, nullptr, 0);
}

void WorkerProcess::set_stopped(bool stopped) const {
  if (handle_)
    ::syscall(SYS_pidfd_send_signal, handle_.get(), stopped ? SIGSTOP : SIGCONT, nullptr, 0);
}

bool WorkerProcess::is_idle() const {
  pollfd look{socket_.get(), POLLIN, 0};
  return ::poll(&look, 1, 0) == 0;  // it sends nothing unasked: a readable socket means its end
}

std::int64_t WorkerProcess::resident_bytes() const {
  return jobs::resident_bytes(std::to_string(process_));
}

std::optional<WorkerExit> WorkerProcess::exit() {
  const WorkerExit unknown{"an unknown exit code"};
  if (process_ == 0) {
    pollfd look{handle_.get(), POLLIN, 0};
    return ::poll(&look, 1, 0) > 0 ? std::optional(unknown) : std::nullopt;
  }

  int status = 0;
  const pid_t collected = collect(process_, WNOHANG, status);
  if (collected == 0) return std::nullopt;
  if (std::exchange(process_, 0) != collected) return unknown;

  WorkerExit exit{describe_exit(status)};
  if (WIFEXITED(status)) exit.code = WEXITSTATUS(status);
  return exit;
}

void WorkerProcess::wait_until(short events, const CallLimits& limits) const {
  pollfd look{socket_.get(), events, 0};
  for (;;) {
    // Checked before the poll, so that a worker that sends events without a pause can be cancelled,
    // too.
    if (limits.called_off())
      throw WorkerDidNotAnswer(Why::called_off, "the caller no longer waits for the answer");
    if (std::chrono::steady_clock::now() > limits.deadline)
      throw WorkerDidNotAnswer(Why::too_slow, fmt::format("{} exceeded its time limit", name_));

    if (::poll(&look, 1, poll_interval_ms) > 0) return;

    if (resident_bytes() > limits.largest_bytes)
      throw WorkerDidNotAnswer(
          Why::too_large,
          fmt::format("{} took more than {}", name_, storage::megabytes(limits.largest_bytes)));
  }
}

void WorkerProcess::send(const google::protobuf::MessageLite& message, const CallLimits& limits) {
  std::ostringstream text;
  google::protobuf::util::SerializeDelimitedToOstream(message, &text);
  const std::string framed = std::move(text).str();

  for (std::string_view bytes = framed; !bytes.empty();) {
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

v1::WorkerAnswer WorkerProcess::receive(const CallLimits& limits) {
  for (;;) {
    google::protobuf::io::CodedInputStream input(
        reinterpret_cast<const std::uint8_t*>(received_.data()),
        static_cast<int>(received_.size()));
    std::uint32_t size = 0;
    const bool has_size = input.ReadVarint32(&size);
    const auto begin = static_cast<std::size_t>(input.CurrentPosition());

    v1::WorkerAnswer answer;
    const bool whole = has_size && received_.size() - begin >= size;
    const bool wrong_size = has_size ? size > largest_answer : received_.size() >= longest_varint;

    if (wrong_size ||
        (whole && !answer.ParseFromArray(received_.data() + begin, static_cast<int>(size))))
      throw WorkerDidNotAnswer(Why::died,
                               fmt::format("{} sent an answer that cannot be read", name_));

    if (whole) {
      // A copy: erasing from the front would keep the buffer of a large answer.
      received_ = received_.substr(begin + size);
      return answer;
    }

    receive_more(limits);
  }
}

void WorkerProcess::receive_more(const CallLimits& limits) {
  std::array<char, 1 << 16> piece;
  for (;;) {
    const auto size = ::recv(socket_.get(), piece.data(), piece.size(), MSG_DONTWAIT);
    if (size > 0) {
      received_.append(piece.data(), static_cast<std::size_t>(size));
      return;
    }
    if (size < 0 && errno == EAGAIN)
      wait_until(POLLIN, limits);
    else if (size == 0 || errno != EINTR)
      report_death();
  }
}

void WorkerProcess::report_death() {
  wait_for_end(process_);
  ::kill(process_, SIGKILL);

  int status = 0;
  const pid_t process = std::exchange(process_, 0);
  if (collect(process, 0, status) != process)
    throw WorkerDidNotAnswer(Why::died, fmt::format("{} ended with an unknown exit code", name_));

  const bool killed =
      WIFSIGNALED(status) && (WTERMSIG(status) == SIGKILL || WTERMSIG(status) == SIGTERM);
  throw WorkerDidNotAnswer(killed ? Why::killed : Why::died,
                           fmt::format("{} ended with {}", name_, describe_exit(status)));
}

}  // namespace dccast::jobs
