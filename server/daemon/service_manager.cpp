#include "server/daemon/service_manager.hpp"

#include <fmt/core.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <utility>

#include "server/jobs/log.hpp"
#include "server/jobs/processes.hpp"

namespace dccast::daemon {

namespace {

/// @return 0 if `text` is no number
long long number(const std::string& text) {
  long long value = 0;
  const auto end = text.data() + text.size();
  return std::from_chars(text.data(), end, value).ptr == end ? value : 0;
}

}  // namespace

ServiceManager::ServiceManager()
    : address_(jobs::take_variable("NOTIFY_SOCKET")), interval_(std::chrono::seconds(10)) {
  const long long watchdog_us = number(jobs::take_variable("WATCHDOG_USEC"));
  const std::string watched_process = jobs::take_variable("WATCHDOG_PID");
  watched_ = watchdog_us > 0 && (watched_process.empty() || number(watched_process) == ::getpid());
  if (watched_)
    interval_ = std::clamp(Milliseconds(watchdog_us / 4000), Milliseconds(1), interval_);
  if (address_.empty()) return;

  if (address_.front() == '@') address_.front() = '\0';  // an abstract name instead of a file
  socket_ = storage::FileDescriptor(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  // A manager that does not read must not hold up the end of the daemon.
  constexpr timeval longest{.tv_sec = 1, .tv_usec = 0};
  ::setsockopt(socket_.get(), SOL_SOCKET, SO_SNDTIMEO, &longest, sizeof longest);
}

void ServiceManager::send(const std::string& lines) const {
  if (address_.empty()) return;

  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  const std::size_t length = std::min(address_.size(), sizeof to.sun_path);
  std::copy_n(address_.begin(), length, to.sun_path);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + length);
  if (::sendto(socket_.get(), lines.data(), lines.size(), MSG_NOSIGNAL,
               reinterpret_cast<const sockaddr*>(&to), size) < 0)
    log::warn("cannot report to the service manager: {}", ::strerror(errno));
}

void ServiceManager::ready(std::function<std::string(Milliseconds)> status) {
  if (address_.empty()) return;
  send(fmt::format("READY=1\nSTATUS={}", status(interval_)));
  reporter_ = std::jthread(
      [this, status = std::move(status)](const std::stop_token& stop) { report(stop, status); });
}

void ServiceManager::report(const std::stop_token& stop,
                            const std::function<std::string(Milliseconds)>& status) {
  std::mutex mutex;
  std::condition_variable_any ended;
  std::unique_lock lock(mutex);
  while (!ended.wait_for(lock, stop, interval_, [&] { return stop.stop_requested(); })) {
    const std::string text = status(interval_);
    if (text.empty())
      log::error("the scheduler thread is stuck; watchdog ping withheld");
    else
      send(fmt::format("{}STATUS={}", watched_ ? "WATCHDOG=1\n" : "", text));
  }
}

void ServiceManager::stopping(const std::string& why) {
  reporter_ = {};
  send(fmt::format("STOPPING=1\nSTATUS={}", why));
}

}  // namespace dccast::daemon
