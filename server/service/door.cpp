#include "server/service/door.hpp"

#include <poll.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>

#include "server/jobs/log.hpp"

namespace dccast::service {

namespace {

// After a refusal by the system, e.g. for want of descriptors, the connection stays in its queue.
constexpr std::chrono::milliseconds pause_after_refusal{100};

ino_t socket_behind(int descriptor) {
  struct stat status;
  return ::fstat(descriptor, &status) == 0 ? status.st_ino : 0;
}

}  // namespace

Door::Door(int listening, std::size_t maximum_connections, std::function<void(int)> admit)
    : listening_(listening),
      maximum_connections_(maximum_connections),
      admit_(std::move(admit)),
      ended_(::eventfd(0, EFD_CLOEXEC)),
      thread_([this] { run(); }) {}

Door::~Door() {
  ::eventfd_write(ended_.get(), 1);
  thread_.join();
}

void Door::run() {
  std::array<pollfd, 2> waiting{{{listening_, POLLIN, 0}, {ended_.get(), POLLIN, 0}}};
  for (;;) {
    if (::poll(waiting.data(), waiting.size(), -1) < 0) continue;
    if (waiting[1].revents != 0) return;
    accept_one();
  }
}

void Door::accept_one() {
  const int connection = ::accept4(listening_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
  if (connection < 0) {
    if (errno != EMFILE && errno != ENFILE && errno != ENOMEM && errno != ENOBUFS) return;
    spdlog::warn("cannot take a connection: {}", ::strerror(errno));
    std::this_thread::sleep_for(pause_after_refusal);
    return;
  }
  const bool was_full = std::exchange(full_, count_open() >= maximum_connections_);
  if (full_ && !was_full)
    spdlog::warn("{} connections are open; further ones are closed until one of them ends",
                 maximum_connections_);
  if (full_) {
    ::close(connection);
    return;
  }
  admitted_.emplace_back(connection, socket_behind(connection));
  admit_(connection);
}

/// A descriptor that was closed is free, or belongs to something else by now.
std::size_t Door::count_open() {
  if (admitted_.size() >= maximum_connections_)
    std::erase_if(admitted_, [](const std::pair<int, ino_t>& connection) {
      return socket_behind(connection.first) != connection.second;
    });
  return admitted_.size();
}

}  // namespace dccast::service
