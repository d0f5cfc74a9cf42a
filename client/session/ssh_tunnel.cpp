#include "client/session/ssh_tunnel.hpp"

#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <iostream>
#include <regex>

#include "client/session/connection.hpp"

namespace dccast::client {
namespace {

std::vector<std::string> command_for(const std::string& server) {
  // No name begins with a dash: ssh would take it for an option.
  static const std::regex form(
      R"(ssh://((?:[A-Za-z0-9_.][\w.-]*@)?[A-Za-z0-9_.][\w.-]*)(?::(\d{1,5}))?(?:/(\d{1,5})?)?)");
  std::smatch parts;
  if (!std::regex_match(server, parts, form))
    throw CommandFailed(ExitCode::invalid, "--server " + server +
                                               ": write ssh://[USER@]HOST[:SSH_PORT][/PORT], where "
                                               "PORT is that of dccastd on HOST (7117)");
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

/// What goes over the connection is standard input and output of an ssh of its own.
void SshTunnel::connect(int connection) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, connection, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, connection, STDOUT_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  std::vector<char*> words;
  for (std::string& word : command_) words.push_back(word.data());
  words.push_back(nullptr);
  pid_t process = 0;
  const int error =
      ::posix_spawnp(&process, words[0], &actions, &attributes, words.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (error == 0)
    processes_.push_back(process);
  else
    std::cerr << "dccast: ssh cannot be started: " << ::strerror(error) << std::endl;
}

void SshTunnel::reap(bool all) {
  std::erase_if(processes_,
                [all](int process) { return ::waitpid(process, nullptr, all ? 0 : WNOHANG) != 0; });
}

}  // namespace dccast::client
