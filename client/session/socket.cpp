#include "client/session/socket.hpp"

#include <fcntl.h>
#include <netdb.h>
#include <poll.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <array>
#include <cerrno>

namespace dccast::client {
namespace {

/// Connects without waiting longer than the limit. @return 0 or the error of the system
int connect_within(int descriptor, const addrinfo& to, std::chrono::milliseconds timeout) {
  const int flags = ::fcntl(descriptor, F_GETFL);
  ::fcntl(descriptor, F_SETFL, flags | O_NONBLOCK);
  if (::connect(descriptor, to.ai_addr, to.ai_addrlen) != 0) {
    if (errno != EINPROGRESS) return errno;
    pollfd waiting{descriptor, POLLOUT, 0};
    if (::poll(&waiting, 1, static_cast<int>(timeout.count())) != 1) return ETIMEDOUT;
    int error = 0;
    socklen_t size = sizeof error;
    ::getsockopt(descriptor, SOL_SOCKET, SO_ERROR, &error, &size);
    if (error != 0) return error;
  }
  ::fcntl(descriptor, F_SETFL, flags);
  const timeval limit{timeout.count() / 1000, (timeout.count() % 1000) * 1000};
  ::setsockopt(descriptor, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  ::setsockopt(descriptor, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
  return 0;
}

Socket::Outcome outcome_of(int error) {
  switch (error) {
    case ECONNREFUSED:
      return Socket::Outcome::refused;
    case ETIMEDOUT:
      return Socket::Outcome::timed_out;
    case EHOSTUNREACH:
    case ENETUNREACH:
      return Socket::Outcome::no_route;
    default:
      return Socket::Outcome::failed;
  }
}

}  // namespace

std::string name_of_this_machine() {
  std::array<char, 256> name{};
  ::gethostname(name.data(), name.size() - 1);
  return name.data();
}

Socket::~Socket() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Socket::Outcome Socket::connect(const values::HostAndPort& to, std::chrono::milliseconds timeout,
                                std::string& reason) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* all = nullptr;
  if (const int error = ::getaddrinfo(to.host.c_str(), to.port.c_str(), &hints, &all)) {
    reason = ::gai_strerror(error);
    return Outcome::no_name;
  }
  int error = 0;
  for (const addrinfo* one = all; one != nullptr; one = one->ai_next) {
    const int tried = ::socket(one->ai_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const int failed = tried < 0 ? errno : connect_within(tried, *one, timeout);
    if (failed == 0) {
      descriptor_ = tried;
      break;
    }
    if (error == 0) error = failed;  // the first is the cause
    if (tried >= 0) ::close(tried);
  }
  ::freeaddrinfo(all);
  if (descriptor_ >= 0) return Outcome::connected;
  reason = ::strerror(error);
  return outcome_of(error);
}

std::string Socket::exchange(const std::string& sent) {
  std::array<char, 64> bytes;
  if (::send(descriptor_, sent.data(), sent.size(), MSG_NOSIGNAL) < 0) return "";
  const auto size = ::recv(descriptor_, bytes.data(), bytes.size(), 0);
  return size > 0 ? std::string(bytes.data(), static_cast<std::size_t>(size)) : "";
}

}  // namespace dccast::client
