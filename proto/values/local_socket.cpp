#include "proto/values/local_socket.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>

namespace dccast::values {

namespace {

/// A socket in the directory that a variable of the environment names.
std::optional<std::string> socket_in(const char* variable) {
  const char* value = std::getenv(variable);
  if (value == nullptr || *value != '/') return std::nullopt;
  const std::string directories = value;  // several of systemd stand between colons
  const std::string path = directories.substr(0, directories.find(':')) + "/dccastd.sock";
  if (path.size() >= sizeof sockaddr_un::sun_path) return std::nullopt;
  return path;
}

}  // namespace

std::optional<std::string> own_socket() {
  const auto of_service = socket_in("RUNTIME_DIRECTORY");
  return of_service ? of_service : socket_in("XDG_RUNTIME_DIR");
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
  const auto own = socket_in("XDG_RUNTIME_DIR");
  if (own && is_listening(*own)) return "unix:" + *own;
  return is_listening(service_socket) ? std::string("unix:") + service_socket : "127.0.0.1";
}

}  // namespace dccast::values
