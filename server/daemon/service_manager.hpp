#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <thread>

#include "core/storage/file.hpp"

namespace dccast::daemon {

/// systemd, where it has started the daemon with Type=notify: each message is one datagram of lines
/// VARIABLE=value to the socket it names, sd_notify(3). Without one nothing is sent.
class ServiceManager {
public:
  using Milliseconds = std::chrono::milliseconds;

  /// Takes NOTIFY_SOCKET, WATCHDOG_USEC and WATCHDOG_PID out of the environment: workers are not to
  /// answer for the daemon. Before any thread.
  ServiceManager();

  /// It serves. From now on `status` is called in a thread of its own, four times in the time in
  /// which the manager expects a sign of life; each answer is such a sign, and what `systemctl
  /// status` shows.
  /// @param status  given the time in which it should answer; nothing: no sign of life
  void ready(std::function<std::string(Milliseconds)> status);
  /// It stops; `status` is called no more.
  void stopping(const std::string& why);

private:
  void send(const std::string& lines) const;
  void report(const std::stop_token& stop, const std::function<std::string(Milliseconds)>& status);

  std::string address_;  ///< of the socket, as the kernel takes it; empty: no manager
  storage::FileDescriptor socket_;
  Milliseconds interval_;
  bool watched_ = false;  ///< the manager expects signs of life
  std::jthread reporter_;
};

}  // namespace dccast::daemon
