#include "client/session/ssh_tunnel.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <fstream>
#include <iostream>
#include <regex>

#include "client/session/connection.hpp"
#include "proto/values/printable.hpp"

namespace dccast::client {
namespace {

constexpr std::size_t target_word = 3;  // of command_for's

std::vector<std::string> command_for(const std::string& server) {
  // No name begins with a dash: ssh would take it for an option.
  static const std::regex form(
      R"(ssh://((?:[A-Za-z0-9_.][\w.-]*@)?[A-Za-z0-9_.][\w.-]*)(?::(\d{1,5}))?(?:/(\d{1,5})?)?)");
  std::smatch parts;
  if (!std::regex_match(server, parts, form))
    throw invalid("--server " + server +
                  ": write ssh://[USER@]HOST[:SSH_PORT][/PORT], where PORT is that of dccastd on "
                  "HOST (7117)");
  const std::string port = parts[3].matched ? ":" + parts[3].str() : default_port;
  std::vector<std::string> command{"ssh", "-T", "-W", "127.0.0.1" + port};
  if (parts[2].matched) command.insert(command.end(), {"-p", parts[2].str()});
  command.insert(command.end(), {"--", parts[1].str()});
  return command;
}

[[noreturn]] void fail(const std::string& what) {
  throw CommandFailed(ExitCode::unreachable,
                      "ssh cannot be used: " + what + ": " + ::strerror(errno));
}

/// What goes over the connection is standard input and output of an ssh of its own.
/// @return its process, or the error of the system
std::pair<pid_t, int> spawn(std::vector<std::string> command, int connection, int errors) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, connection, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, connection, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, errors, STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  std::vector<char*> words;
  for (std::string& word : command) words.push_back(word.data());
  words.push_back(nullptr);
  pid_t process = 0;
  const int error =
      ::posix_spawnp(&process, words[0], &actions, &attributes, words.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return {process, error};
}

/// The last line of what ssh wrote, or the one before it by which the other machine refuses the
/// port.
std::string reason_in(const std::filesystem::path& messages) {
  std::ifstream stream(messages);
  std::string line, reason;
  while (std::getline(stream, line)) {
    while (!line.empty() && std::isspace(static_cast<unsigned char>(line.back()))) line.pop_back();
    if (!line.empty() && reason.find("open failed") == std::string::npos) reason = line;
  }
  return reason;
}

/// "ssh -p 2222 anna@casthouse": as a person would type it, without the forwarding.
std::string login_of(const std::vector<std::string>& command) {
  std::string text = "ssh";
  for (std::size_t word = target_word + 1; word < command.size(); ++word)
    if (command[word] != "--") text += " " + command[word];
  return text;
}

/// Why an ssh ended without an answer.
/// @param port  that it was to reach; @param login  the same ssh as a person types it
Diagnosis judge(int exit_code, const std::string& reason, const std::string& port,
                const std::string& login) {
  const auto has = [&](const char* text) { return reason.find(text) != std::string::npos; };
  if (has("administratively prohibited"))
    return {"ssh logs in, but the other machine forbids forwarding (" + reason + ")",
            "ask its admin for AllowTcpForwarding, or for a login over TLS"};
  if (has("open failed") || has("stdio forwarding failed"))
    return {"ssh logs in, but nothing takes connections at " + port + " (" + reason + ")",
            "start dccastd there, or give the port of its `listen`: ssh://HOST/PORT"};
  if (exit_code != 0)
    return {"ssh ended with exit code " + std::to_string(exit_code) +
                (reason.empty() ? ", without a message" : ": " + reason),
            "mend that first, with " + login + " alone"};
  return {"what listens at " + port + " closes the connection without an answer",
          "give the port of `listen`, not that of listen_tls: ssh://HOST/PORT"};
}

}  // namespace

SshTunnel::SshTunnel(const std::string& server) : command_(command_for(server)) {
  std::string folder = std::filesystem::temp_directory_path() / "dccast-ssh-XXXXXX";
  if (::mkdtemp(folder.data()) == nullptr) fail(folder);
  socket_ = std::filesystem::path(folder) / "socket";
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (socket_.native().size() >= sizeof address.sun_path) {
    errno = ENAMETOOLONG;
    fail(socket_.string());
  }
  ::strcpy(address.sun_path, socket_.c_str());
  listener_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  ended_ = ::eventfd(0, EFD_CLOEXEC);
  if (listener_ < 0 || ended_ < 0 ||
      ::bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      ::listen(listener_, SOMAXCONN) != 0)
    fail(socket_.string());
  thread_ = std::thread([this] { run(); });
}

const std::string& SshTunnel::target() const {
  return command_[target_word];
}

SshTunnel::~SshTunnel() {
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = ::write(ended_, &one, sizeof one);
  thread_.join();
  for (const int process : processes_) ::kill(process, SIGTERM);
  reap(true);
  ::close(listener_);
  ::close(ended_);
  std::error_code ignored;
  std::filesystem::remove_all(socket_.parent_path(), ignored);
}

void SshTunnel::run() {
  std::array<pollfd, 2> awaited{{{listener_, POLLIN, 0}, {ended_, POLLIN, 0}}};
  for (;;) {
    if (::poll(awaited.data(), awaited.size(), -1) < 0 && errno != EINTR) return;
    if (awaited[1].revents != 0) return;
    if (awaited[0].revents == 0) continue;
    const int connection = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    reap(false);
    if (connection < 0) continue;
    connect(connection);
    ::close(connection);
  }
}

void SshTunnel::connect(int connection) {
  const auto [process, error] = spawn(command_, connection, STDERR_FILENO);
  if (error == 0)
    processes_.push_back(process);
  else
    std::cerr << "dccast: ssh cannot be started: " << ::strerror(error) << std::endl;
}

Diagnosis SshTunnel::try_once(const std::string& greeting, std::chrono::milliseconds timeout,
                              std::string& answer) const {
  std::vector<std::string> command = command_;
  const auto seconds = std::chrono::ceil<std::chrono::seconds>(timeout).count();
  command.insert(command.begin() + 1, {"-o", "ConnectTimeout=" + std::to_string(seconds)});
  // A file, not a pipe: a master that ssh leaves behind (ControlPersist) would hold that open.
  const std::filesystem::path messages = socket_.parent_path() / "messages";
  const int errors = ::open(messages.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  std::array<int, 2> ends{-1, -1};
  if (errors < 0 || ::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
    fail(messages.string());
  const auto [process, error] = spawn(std::move(command), ends[1], errors);
  ::close(ends[1]);
  ::close(errors);
  bool timed_out = false;
  int status = 0;
  if (error == 0) {
    ::send(ends[0], greeting.data(), greeting.size(), MSG_NOSIGNAL);
    pollfd awaited{ends[0], POLLIN, 0};
    timed_out = ::poll(&awaited, 1, static_cast<int>(4 * timeout.count())) == 0;
    std::array<char, 64> bytes;
    const auto size = timed_out ? 0 : ::recv(ends[0], bytes.data(), bytes.size(), 0);
    answer.assign(bytes.data(), static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
    if (timed_out || !answer.empty()) ::kill(process, SIGTERM);
    ::waitpid(process, &status, 0);
  }
  ::close(ends[0]);
  if (error != 0)
    return {std::string("ssh cannot be started: ") + ::strerror(error),
            "install it (package openssh-client)"};
  if (!answer.empty()) return {};
  const std::string port = target() + " there", login = login_of(command_);
  if (timed_out)
    return {"ssh has brought no answer in time: it waits for a person, or what listens at " + port +
                " does not answer",
            "try " + login + ", and there dccast doctor"};
  return judge(WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
               values::escaped(reason_in(messages)), port, login);
}

void SshTunnel::reap(bool all) {
  std::erase_if(processes_,
                [all](int process) { return ::waitpid(process, nullptr, all ? 0 : WNOHANG) != 0; });
}

}  // namespace dccast::client
