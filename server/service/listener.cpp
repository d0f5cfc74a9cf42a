#include "server/service/listener.hpp"

#include <linux/tcp.h>
#include <malloc.h>
#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <memory>
#include <stdexcept>

#include "proto/values/address.hpp"
#include "server/jobs/log.hpp"

namespace dccast::service {

namespace {

// After a refusal by the system, e.g. for want of descriptors, the connection stays in its queue.
constexpr std::chrono::milliseconds pause_after_refusal{100};

std::string host_of(const std::string& address) {
  return address.substr(0, address.rfind(':'));
}

/// "localhost" is 127.0.0.1: one socket, and every client tries that one too.
std::string numeric(const std::string& address) {
  const std::string host = host_of(address);
  return host == "localhost" ? "127.0.0.1" + address.substr(host.size()) : address;
}

[[noreturn]] void fail(const std::string& address, const std::string& reason) {
  throw std::runtime_error("cannot listen on " + address + ": " + reason +
                           "; is another dccastd there? Port 0 takes a free one");
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

std::string host_of(const sockaddr_storage& address, socklen_t size) {
  std::array<char, NI_MAXHOST> host{};
  ::getnameinfo(reinterpret_cast<const sockaddr*>(&address), size, host.data(), host.size(),
                nullptr, 0, NI_NUMERICHOST);
  return host.data();
}

/// As gRPC writes it: "ipv4:192.0.2.1:40000", "ipv6:%5B::1%5D:40000".
std::string peer_of(const std::string& host, const sockaddr_storage& address) {
  return (address.ss_family == AF_INET6 ? "ipv6:%5B" + host + "%5D:" : "ipv4:" + host + ":") +
         port_of(address);
}

std::uint64_t bytes_received(int socket) {
  tcp_info info{};
  socklen_t size = sizeof info;
  if (::getsockopt(socket, IPPROTO_TCP, TCP_INFO, &info, &size) != 0) return UINT64_MAX;
  return info.tcpi_bytes_received;
}

}  // namespace

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
  sockaddr_storage bound{};
  socklen_t size = sizeof bound;
  ::getsockname(socket_.get(), reinterpret_cast<sockaddr*>(&bound), &size);
  address_ = host_of(numeric(address)) + ":" + port_of(bound);
}

Listener::~Listener() {
  stop();
}

void Listener::start(const Bounds& bounds, std::function<void(int)> admit) {
  bounds_ = bounds;
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
    constexpr int between_trims_ms = 2000;
    const int ready = ::poll(waiting.data(), waiting.size(), between_trims_ms);
    if (ready == 0) trim();
    if (ready <= 0) continue;
    if (waiting[1].revents != 0) return;
    pace();
    accept_one();
  }
}

/// A client whose connection was ended for what it sent comes back at once. Each such end delays
/// the next connection, whichever client it is from: local ones have the same address.
void Listener::pace() {
  constexpr std::chrono::milliseconds per_ended{25};
  constexpr int most_at_once = 8;
  const int ended = hostile_->exchange(0);
  trim_is_due_ = trim_is_due_ || ended > 0;
  std::this_thread::sleep_for(std::min(ended, most_at_once) * per_ended);
}

/// What hostile connections held goes back to the system: the C library keeps it otherwise.
void Listener::trim() {
  if (hostile_->exchange(0) > 0 || trim_is_due_) ::malloc_trim(0);
  trim_is_due_ = false;
}

void Listener::accept_one() {
  sockaddr_storage from{};
  socklen_t size = sizeof from;
  const int connection = ::accept4(socket_.get(), reinterpret_cast<sockaddr*>(&from), &size,
                                   SOCK_CLOEXEC | SOCK_NONBLOCK);
  if (connection < 0) {
    if (errno != EMFILE && errno != ENFILE && errno != ENOMEM && errno != ENOBUFS) return;
    log::warn("cannot take a connection: {}", ::strerror(errno));
    std::this_thread::sleep_for(pause_after_refusal);
    return;
  }
  const std::string host = host_of(from, size);
  const bool was_full = std::exchange(full_, !has_room(host));
  if (full_ && !was_full)
    log::warn("all connections are in use, or those of {}; further ones are closed until one ends",
              host);
  if (full_) {
    ::close(connection);
    return;
  }
  admitted_.push_back(
      {connection, socket_behind(connection), host, std::chrono::steady_clock::now()});
  const std::string peer = peer_of(host, from);
  watch_connection(connection, peer, bounds_.over_tls, hostile_);
  admit_(connection);
}

bool Listener::has_room(const std::string& host) {
  const auto has_its_share = [&] {
    return static_cast<std::size_t>(std::ranges::count(admitted_, host, &Admitted::host)) >=
           bounds_.per_peer;
  };
  // A descriptor that was closed is free, or belongs to something else by now.
  if (admitted_.size() >= bounds_.connections || has_its_share())
    std::erase_if(admitted_, [](const Admitted& connection) {
      return socket_behind(connection.descriptor) != connection.socket;
    });
  if (has_its_share() && !end_a_silent_one(host)) return false;
  return admitted_.size() < bounds_.connections || end_a_silent_one("");
}

/// Ends the oldest connection that has not made a request in its first second, for one that may.
/// gRPC sees its end and closes it. @param host  only one of this; empty: any
bool Listener::end_a_silent_one(const std::string& host) {
  constexpr std::chrono::seconds time_to_first_request{1};
  const auto now = std::chrono::steady_clock::now();
  for (auto one = admitted_.begin(); one != admitted_.end(); ++one) {
    if (now - one->since < time_to_first_request) return false;
    if (!host.empty() && one->host != host) continue;
    if (bytes_received(one->descriptor) > bounds_.greeting_bytes) continue;
    ::shutdown(one->descriptor, SHUT_RDWR);
    admitted_.erase(one);
    return true;
  }
  return false;
}

}  // namespace dccast::service
