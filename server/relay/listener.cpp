#include "server/relay/listener.hpp"

#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <memory>
#include <stdexcept>
#include <string_view>

#include "proto/values/address.hpp"

namespace dccast::relay {

namespace {

constexpr std::string_view unix_scheme = "unix:";

std::string host_part(const std::string& address) {
  return address.substr(0, address.rfind(':'));
}

/// "localhost" is 127.0.0.1: one socket, and every client tries that one too.
std::string numeric(const std::string& address) {
  const std::string host = host_part(address);
  return host == "localhost" ? "127.0.0.1" + address.substr(host.size()) : address;
}

[[noreturn]] void fail(const std::string& address, const std::string& reason) {
  throw std::runtime_error(fmt::format(
      "cannot listen on {}: {}; is another dccastd there? Give this one another address", address,
      reason));
}

using Addresses = std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)>;

Addresses resolve(const std::string& address) {
  const auto [host, port] = values::host_and_port(numeric(address));
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int error = ::getaddrinfo(host.c_str(), port.c_str(), &hints, &found);
  if (error != 0) fail(address, ::gai_strerror(error));
  return {found, &::freeaddrinfo};
}

void set(int socket, int level, int option) {
  constexpr int yes = 1;
  ::setsockopt(socket, level, option, &yes, sizeof yes);
}

/// The port stands at the same place for IPv4 and IPv6.
std::string port_of(const sockaddr_storage& address) {
  return std::to_string(ntohs(reinterpret_cast<const sockaddr_in*>(&address)->sin_port));
}

}  // namespace

Listener::Listener(const std::string& address) : address_(address) {
  if (address.starts_with(unix_scheme))
    listen_at_path(address.substr(unix_scheme.size()));
  else
    listen_on_port(address);
}

Listener::~Listener() {
  if (address_.starts_with(unix_scheme)) ::unlink(address_.substr(unix_scheme.size()).c_str());
}

void Listener::listen_at_path(const std::string& path) {
  sockaddr_un place{};
  place.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof place.sun_path)
    throw std::runtime_error(
        fmt::format("cannot listen on {}: the path of a Unix socket has 1 to {} bytes; set "
                    "listen.socket to a shorter unix:PATH",
                    address_, sizeof place.sun_path - 1));
  path.copy(place.sun_path, path.size());
  const auto* name = reinterpret_cast<const sockaddr*>(&place);

  // A daemon that was killed leaves its socket; one that lives answers.
  struct stat status;
  if (::lstat(path.c_str(), &status) == 0 && S_ISSOCK(status.st_mode)) {
    const storage::FileDescriptor caller(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
    if (::connect(caller.get(), name, sizeof place) != 0) ::unlink(path.c_str());
  }

  socket_ =
      storage::FileDescriptor(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket_ || ::bind(socket_.get(), name, sizeof place) != 0) fail(address_, ::strerror(errno));
  // Every local user may call; who calls is known by the socket.
  constexpr mode_t for_everyone = 0666;
  if (::chmod(path.c_str(), for_everyone) != 0 || ::listen(socket_.get(), SOMAXCONN) != 0)
    fail(address_, ::strerror(errno));
}

void Listener::listen_on_port(const std::string& address) {
  const Addresses found = resolve(address);
  socket_ = storage::FileDescriptor(
      ::socket(found->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket_) fail(address, ::strerror(errno));

  set(socket_.get(), SOL_SOCKET, SO_REUSEADDR);  // connections of a daemon that has ended linger
  set(socket_.get(), IPPROTO_TCP, TCP_NODELAY);  // what is accepted here inherits it
  if (::bind(socket_.get(), found->ai_addr, found->ai_addrlen) != 0 ||
      ::listen(socket_.get(), SOMAXCONN) != 0)
    fail(address, ::strerror(errno));

  sockaddr_storage bound{};
  socklen_t size = sizeof bound;
  ::getsockname(socket_.get(), reinterpret_cast<sockaddr*>(&bound), &size);
  address_ = host_part(numeric(address)) + ":" + port_of(bound);
}

std::string host_of(const sockaddr_storage& address, socklen_t size) {
  if (address.ss_family == AF_UNIX) return "unix";
  std::array<char, NI_MAXHOST> host{};
  ::getnameinfo(reinterpret_cast<const sockaddr*>(&address), size, host.data(), host.size(),
                nullptr, 0, NI_NUMERICHOST);
  return host.data();
}

std::string uri_of(const std::string& host, const sockaddr_storage& address) {
  if (address.ss_family == AF_UNIX) return "unix:";
  return address.ss_family == AF_INET6 ? fmt::format("ipv6:%5B{}%5D:{}", host, port_of(address))
                                       : fmt::format("ipv4:{}:{}", host, port_of(address));
}

}  // namespace dccast::relay
