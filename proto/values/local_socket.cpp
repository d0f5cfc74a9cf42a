#include "proto/values/local_socket.hpp"

#include <fmt/format.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <optional>
#include <stdexcept>
#include <vector>

namespace dccast::values {

namespace {

constexpr const char* socket_name = "dccastd.sock";

/// A socket in the directory named by an environment variable.
std::optional<std::string> socket_in(const char* variable) {
  const char* value = std::getenv(variable);
  if (value == nullptr || *value != '/') return std::nullopt;
  const std::string directories = value;  // several of systemd stand between colons
  return fmt::format("{}/{}", directories.substr(0, directories.find(':')), socket_name);
}

/// For users without a runtime directory: after su, in a container.
std::string folder_of_user() {
  return fmt::format("/tmp/dccast-{}", ::geteuid());
}

/// Anyone may create a folder in /tmp and serve there in place of this user's daemon.
bool belongs_to_this_user(const std::string& folder) {
  struct stat status;
  constexpr mode_t writable_by_others = S_IWGRP | S_IWOTH;
  return ::lstat(folder.c_str(), &status) == 0 && S_ISDIR(status.st_mode) &&
         status.st_uid == ::geteuid() && (status.st_mode & writable_by_others) == 0;
}

}  // namespace

std::string default_socket_path() {
  for (const char* variable : {"RUNTIME_DIRECTORY", "XDG_RUNTIME_DIR"})
    if (const auto path = socket_in(variable)) return *path;

  const std::string folder = folder_of_user();
  constexpr mode_t of_this_user_alone = 0700;
  if (::mkdir(folder.c_str(), of_this_user_alone) != 0 && errno != EEXIST)
    throw std::runtime_error(
        fmt::format("cannot make {} for the socket: {}", folder, ::strerror(errno)));
  if (!belongs_to_this_user(folder))
    throw std::runtime_error(
        fmt::format("{} is not a folder that this user alone may write to; remove it, or set "
                    "listen.socket to another unix:PATH",
                    folder));
  return fmt::format("{}/{}", folder, socket_name);
}

bool is_listening(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) return false;
  path.copy(address.sun_path, path.size());

  const int caller = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (caller < 0) return false;
  // The queue of a busy program may be full.
  const bool connected =
      ::connect(caller, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 ||
      errno == EAGAIN;
  ::close(caller);
  return connected;
}

std::string local_server() {
  std::vector<std::string> paths;
  if (const auto path = socket_in("XDG_RUNTIME_DIR")) paths.push_back(*path);
  if (const std::string folder = folder_of_user(); belongs_to_this_user(folder))
    paths.push_back(fmt::format("{}/{}", folder, socket_name));
  paths.emplace_back(service_socket);

  for (const std::string& path : paths)
    if (is_listening(path)) return unix_scheme + path;
  return unix_scheme + paths.front();
}

}  // namespace dccast::values
