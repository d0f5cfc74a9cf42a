#include "server/service/listening_socket.hpp"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <string.h>
#include <sys/socket.h>

#include <cerrno>
#include <memory>
#include <stdexcept>

namespace dccast::service {

namespace {

std::string host_of(const std::string& address) {
  return address.substr(0, address.rfind(':'));
}

[[noreturn]] void fail(const std::string& address, const std::string& reason) {
  throw std::runtime_error("cannot listen on " + address + ": " + reason +
                           "; is another dccastd there? Port 0 takes a free one");
}

using Addresses = std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)>;

/// "localhost" is 127.0.0.1: one socket, and every client tries that one too.
Addresses resolve(const std::string& address) {
  std::string host = host_of(address);
  if (host == "localhost") host = "127.0.0.1";
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const std::string port = address.substr(address.rfind(':') + 1);
  const int error = ::getaddrinfo(host.c_str(), port.c_str(), &hints, &found);
  if (error != 0) fail(address, ::gai_strerror(error));
  return {found, &::freeaddrinfo};
}

void set(int socket, int level, int option) {
  constexpr int yes = 1;
  ::setsockopt(socket, level, option, &yes, sizeof yes);
}

int port_in_use(int socket) {
  sockaddr_storage bound{};
  socklen_t size = sizeof bound;
  if (::getsockname(socket, reinterpret_cast<sockaddr*>(&bound), &size) != 0) return 0;
  // The port stands at the same place for IPv4 and IPv6.
  return ntohs(reinterpret_cast<const sockaddr_in*>(&bound)->sin_port);
}

}  // namespace

bool is_loopback(const std::string& address) {
  const std::string host = host_of(address);
  return host == "localhost" || host == "[::1]" ||
         (host.starts_with("127.") && host.find_first_not_of("0123456789.") == std::string::npos);
}

ListeningSocket::ListeningSocket(const std::string& address) {
  const Addresses found = resolve(address);
  socket_ = storage::FileDescriptor(
      ::socket(found->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket_) fail(address, ::strerror(errno));
  set(socket_.get(), SOL_SOCKET, SO_REUSEADDR);  // connections of a daemon that has ended linger
  set(socket_.get(), IPPROTO_TCP, TCP_NODELAY);  // what is accepted here inherits it
  if (::bind(socket_.get(), found->ai_addr, found->ai_addrlen) != 0 ||
      ::listen(socket_.get(), SOMAXCONN) != 0)
    fail(address, ::strerror(errno));
  std::string host = host_of(address);
  if (host == "localhost") host = "127.0.0.1";
  address_ = host + ":" + std::to_string(port_in_use(socket_.get()));
}

}  // namespace dccast::service
