#include "client/session/ssh_tunnel.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstdint>
#include <fstream>
#include <regex>

#include "client/session/connection.hpp"
#include "proto/values/local_socket.hpp"
#include "proto/values/printable.hpp"

namespace dccast::client {
namespace {

using std::chrono::milliseconds;

/// Exit code of a shell for a program that it cannot start.
constexpr int cannot_be_started = 127;

struct Target {
  std::string login;  ///< "anna@casthouse"
  std::string port;   ///< of ssh; empty: the usual one
  std::string path;   ///< of the socket there
};

Target read_target(const std::string& server) {
  // A name that begins with a dash would be an option of ssh.
  static const std::regex form(
      R"(ssh://((?:[A-Za-z0-9_.][\w.-]*@)?[A-Za-z0-9_.][\w.-]*)(?::(\d{1,5}))?(/[\w./@+-]*)?)");
  // A path of digits is a port in the wrong place.
  static const std::regex port(R"(/\d{1,5})");
  constexpr std::size_t longest = sizeof sockaddr_un::sun_path - 1;

  std::smatch parts;
  const bool is_read = std::regex_match(server, parts, form);
  const std::string path = parts[3].str();
  if (!is_read || std::regex_match(path, port) || path.size() > longest)
    throw invalid(
        fmt::format("--server {}: write ssh://[USER@]HOST[:SSH_PORT][/PATH], where PATH is that of "
                    "dccastd's Unix socket on HOST, of at most {} bytes; without it {}",
                    server, longest, values::service_socket));
  return {parts[1].str(), parts[2].str(), path.size() > 1 ? path : values::service_socket};
}

/// @param subject  the action, file or program that the error of the system concerns
[[noreturn]] void fail(const std::string& subject) {
  throw CommandFailed(ExitCode::unreachable,
                      fmt::format("ssh cannot be used: {}: {}", subject, ::strerror(errno)));
}

sockaddr_un address_at(const std::filesystem::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.native().size() >= sizeof address.sun_path) {
    errno = ENAMETOOLONG;
    fail(path.string());
  }
  path.native().copy(address.sun_path, path.native().size());
  return address;
}

/// Starts a program that is killed when this thread ends. Its input and output are /dev/null, its
/// messages go to `errors`.
/// @return its process; negative on failure
pid_t spawn_tied(const std::vector<std::string>& command, int errors) {
  std::vector<char*> words;
  for (const std::string& word : command) words.push_back(const_cast<char*>(word.data()));
  words.push_back(nullptr);
  const pid_t parent = ::getpid();

  const pid_t process = ::fork();
  if (process != 0) return process;
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (::getppid() != parent) ::_exit(cannot_be_started);  // the parent ended before prctl
  sigset_t none;
  sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  const int nothing = ::open("/dev/null", O_RDWR);
  ::dup2(errors, STDERR_FILENO);
  ::dup2(nothing, STDIN_FILENO);
  ::dup2(nothing, STDOUT_FILENO);
  ::execvp(words[0], words.data());
  ::_exit(cannot_be_started);
}

/// The last line that ssh wrote, or the line before it that states why the socket was refused.
std::string reason_in(const std::filesystem::path& messages) {
  std::ifstream stream(messages);
  std::string line, reason;
  while (std::getline(stream, line)) {
    while (!line.empty() && std::isspace(static_cast<unsigned char>(line.back()))) line.pop_back();
    if (!line.empty() && reason.find("open failed") == std::string::npos) reason = line;
  }
  return values::escaped(reason);
}

Diagnosis without_login(int exit_code, const std::string& reason, const std::string& login) {
  if (exit_code == cannot_be_started && reason.empty())
    return {"ssh cannot be started", "install it (package openssh-client)"};
  return {fmt::format("ssh ended with exit code {}{}", exit_code,
                      reason.empty() ? ", without a message" : ": " + reason),
          fmt::format("mend that first, with {} alone", login)};
}

/// Diagnosis of an ssh that has logged in but returns nothing. sshd reports "open failed" both
/// where it forbids forwarding and where it finds no socket.
Diagnosis without_answer(const std::string& reason, const std::string& path) {
  if (reason.find("open failed") != std::string::npos)
    return {
        fmt::format("ssh logs in, but makes no connection to {} there ({})", path, reason),
        "start dccastd there, or give the path of its socket, which its log names: "
        "ssh://HOST/PATH; if it serves there, ask for AllowStreamLocalForwarding of sshd, or for "
        "a login over TLS"};
  return {fmt::format("what listens at {} there closes the connection without an answer", path),
          "give the path of dccastd's socket, which its log names: ssh://HOST/PATH"};
}

}  // namespace

SshTunnel::SshTunnel(const std::string& server) : errors_(STDERR_FILENO) {
  const Target target = read_target(server);
  target_ = target.path;

  std::string folder = std::filesystem::temp_directory_path() / "dccast-ssh-XXXXXX";
  if (::mkdtemp(folder.data()) == nullptr) fail(folder);
  socket_ = std::filesystem::path(folder) / "socket";
  messages_ = std::filesystem::path(folder) / "messages";
  leaving_ = ::eventfd(0, EFD_CLOEXEC);
  if (leaving_ < 0) fail("eventfd");

  // A connection that ssh shares with others would keep this forwarding after our end.
  command_ = {"ssh",
              "-N",
              "-T",
              "-S",
              "none",
              "-o",
              "ServerAliveInterval=15",
              "-L",
              fmt::format("{}:{}", socket_.string(), target_)};
  login_ = "ssh";
  if (!target.port.empty()) {
    command_.insert(command_.end(), {"-p", target.port});
    login_ += " -p " + target.port;
  }
  command_.insert(command_.end(), {"--", target.login});
  login_ += " " + target.login;
}

SshTunnel::~SshTunnel() {
  if (thread_.joinable()) {
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = ::write(leaving_, &one, sizeof one);
    thread_.join();
  }
  if (errors_ != STDERR_FILENO) ::close(errors_);
  ::close(leaving_);
  std::error_code ignored;
  std::filesystem::remove_all(socket_.parent_path(), ignored);
}

void SshTunnel::open() {
  start();
  if (wait_for_login(Clock::time_point::max()) == Login::made) {
    // A caller between the making of the socket and listening is refused, and gRPC pauses then.
    constexpr std::chrono::seconds longest{1};
    ::close(connect_to_socket(Clock::now() + longest));
    return;
  }

  const Diagnosis why = without_login(*exit_code_, "", login_);
  throw CommandFailed(ExitCode::unreachable, fmt::format("{}; {}", why.cause, why.remedy));
}

Diagnosis SshTunnel::open_and_greet(const std::string& greeting, milliseconds timeout,
                                    std::string& answer) {
  errors_ = ::open(messages_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC, 0600);
  if (errors_ < 0) fail(messages_.string());
  const auto seconds = std::chrono::ceil<std::chrono::seconds>(timeout).count();
  command_.insert(command_.begin() + 1, {"-o", fmt::format("ConnectTimeout={}", seconds)});

  // The login may take several exchanges, each within the time limit of ssh.
  const auto end = Clock::now() + 4 * timeout;
  start();
  const Login login = wait_for_login(end);
  if (login == Login::failed) return without_login(*exit_code_, reason_in(messages_), login_);
  if (login == Login::made) answer = greet(greeting, end);
  if (!answer.empty()) return {};
  if (Clock::now() >= end)
    return {fmt::format("ssh has brought no answer in time: it waits for a person, or what listens "
                        "at {} there does not answer",
                        target_),
            fmt::format("try {}, and there dccast doctor", login_)};
  return without_answer(reason_in(messages_), target_);
}

void SshTunnel::start() {
  address_at(socket_);  // no longer than it may be
  thread_ = std::thread([this] { run(); });
}

void SshTunnel::run() {
  for (;;) {
    std::error_code ignored;
    std::filesystem::remove(socket_, ignored);
    const pid_t process = spawn_tied(command_, errors_);
    if (process < 0) return note_end(cannot_be_started << 8);

    // The function pidfd_open() of Debian 12 cannot be linked from C++.
    const int descriptor = static_cast<int>(::syscall(SYS_pidfd_open, process, 0));
    std::array<pollfd, 2> awaited{{{descriptor, POLLIN, 0}, {leaving_, POLLIN, 0}}};
    while (::poll(awaited.data(), awaited.size(), -1) < 0 && errno == EINTR) {
    }
    ::close(descriptor);
    const bool is_leaving = awaited[1].revents != 0;
    if (is_leaving) ::kill(process, SIGTERM);
    int status = 0;
    ::waitpid(process, &status, 0);
    if (is_leaving) return;

    // The first process has to log in; later ones may lack a network for a while.
    if (!has_logged_in_) return note_end(status);
    constexpr int pause_ms = 1000;
    if (::poll(&awaited[1], 1, pause_ms) > 0) return;
  }
}

void SshTunnel::note_end(int wait_status) {
  const std::lock_guard lock(mutex_);
  exit_code_ = WIFEXITED(wait_status) ? WEXITSTATUS(wait_status) : 128 + WTERMSIG(wait_status);
  changed_.notify_all();
}

SshTunnel::Login SshTunnel::wait_for_login(Clock::time_point end) {
  constexpr milliseconds between_looks{10};
  std::unique_lock lock(mutex_);
  // ssh makes the socket once it has logged in.
  for (std::error_code ignored; !std::filesystem::exists(socket_, ignored);) {
    if (changed_.wait_for(lock, between_looks, [this] { return exit_code_.has_value(); }))
      return Login::failed;
    if (Clock::now() >= end) return Login::timed_out;
  }
  has_logged_in_ = true;
  return Login::made;
}

int SshTunnel::connect_to_socket(Clock::time_point end) const {
  const int caller = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (caller < 0) fail("socket");

  constexpr milliseconds between_attempts{10};
  const sockaddr_un address = address_at(socket_);
  while (::connect(caller, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    if (errno != ECONNREFUSED || Clock::now() >= end) break;
    std::this_thread::sleep_for(between_attempts);
  }
  return caller;
}

std::string SshTunnel::greet(const std::string& greeting, Clock::time_point end) const {
  const int caller = connect_to_socket(end);
  ::send(caller, greeting.data(), greeting.size(), MSG_NOSIGNAL);

  pollfd awaited{caller, POLLIN, 0};
  const auto left = std::chrono::ceil<milliseconds>(end - Clock::now()).count();
  std::array<char, 64> bytes;
  const ssize_t size = ::poll(&awaited, 1, static_cast<int>(std::max<long>(left, 0))) > 0
                           ? ::recv(caller, bytes.data(), bytes.size(), 0)
                           : 0;
  ::close(caller);
  return {bytes.data(), static_cast<std::size_t>(std::max<ssize_t>(size, 0))};
}

}  // namespace dccast::client
