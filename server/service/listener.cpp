#include "server/service/listener.hpp"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <memory>
#include <stdexcept>

#include "server/jobs/log.hpp"

namespace dccast::service {

namespace {

// After a refusal by the system, e.g. for want of descriptors, the connection stays in its queue.
constexpr std::chrono::milliseconds pause_after_refusal{100};

ino_t socket_behind(int descriptor) {
  struct stat status;
  return ::fstat(descriptor, &status) == 0 ? status.st_ino : 0;
}

std::string host_of(const std::string& address) {
  return address.substr(0, address.rfind(':'));
}

/// "localhost" is 127.0.0.1: one socket, and every client tries that one too.
std::string numeric_host_of(const std::string& address) {
  const std::string host = host_of(address);
  return host == "localhost" ? "127.0.0.1" : host;
}

[[noreturn]] void fail(const std::string& address, const std::string& reason) {
  throw std::runtime_error("cannot listen on " + address + ": " + reason +
                           "; is another dccastd there? Port 0 takes a free one");
}

using Addresses = std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)>;

Addresses resolve(const std::string& address) {
  std::string host = numeric_host_of(address);
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

Listener::Listener(const std::string& address) : ended_(::eventfd(0, EFD_CLOEXEC)) {
  const Addresses found = resolve(address);
  socket_ = storage::FileDescriptor(
      ::socket(found->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket_) fail(address, ::strerror(errno));
  set(socket_.get(), SOL_SOCKET, SO_REUSEADDR);  // connections of a daemon that has ended linger
  set(socket_.get(), IPPROTO_TCP, TCP_NODELAY);  // what is accepted here inherits it
  if (::bind(socket_.get(), found->ai_addr, found->ai_addrlen) != 0 ||
      ::listen(socket_.get(), SOMAXCONN) != 0)
    fail(address, ::strerror(errno));
  address_ = numeric_host_of(address) + ":" + std::to_string(port_in_use(socket_.get()));
}

Listener::~Listener() {
  stop();
}

void Listener::start(std::size_t maximum_connections, std::function<void(int)> admit) {
  maximum_connections_ = maximum_connections;
  admit_ = std::move(admit);
  thread_ = std::thread([this] { run(); });
}

void Listener::stop() {
  if (!thread_.joinable()) return;
  ::eventfd_write(ended_.get(), 1);
  thread_.join();
}

void Listener::run() {
  std::array<pollfd, 2> waiting{{{socket_.get(), POLLIN, 0}, {ended_.get(), POLLIN, 0}}};
  for (;;) {
    if (::poll(waiting.data(), waiting.size(), -1) < 0) continue;
    if (waiting[1].revents != 0) return;
    accept_one();
  }
}

void Listener::accept_one() {
  const int connection = ::accept4(socket_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
  if (connection < 0) {
    if (errno != EMFILE && errno != ENFILE && errno != ENOMEM && errno != ENOBUFS) return;
    log::warn("cannot take a connection: {}", ::strerror(errno));
    std::this_thread::sleep_for(pause_after_refusal);
    return;
  }
  const bool was_full = std::exchange(full_, count_open() >= maximum_connections_);
  if (full_ && !was_full)
    log::warn("{} connections are open; further ones are closed until one of them ends",
                 maximum_connections_);
  if (full_) {
    ::close(connection);
    return;
  }
  admitted_.emplace_back(connection, socket_behind(connection));
  admit_(connection);
}

/// A descriptor that was closed is free, or belongs to something else by now.
std::size_t Listener::count_open() {
  if (admitted_.size() >= maximum_connections_)
    std::erase_if(admitted_, [](const std::pair<int, ino_t>& connection) {
      return socket_behind(connection.first) != connection.second;
    });
  return admitted_.size();
}

}  // namespace dccast::service
