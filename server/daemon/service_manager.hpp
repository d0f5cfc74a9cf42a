#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <thread>

#include "core/storage/file.hpp"

namespace dccast::daemon {

/// Reports to systemd, if it has started the daemon with Type=notify: each message is one datagram
/// of lines VARIABLE=value to a socket, sd_notify(3). Otherwise nothing is sent.
///
/// This does not use sd_notify() of libsystemd 252: it waits without a limit for a manager that
/// does not read, which would hold up the end of the daemon, and it needs NOTIFY_SOCKET in the
/// environment, which workers would inherit.
class ServiceManager {
public:
  using Milliseconds = std::chrono::milliseconds;

  /// Removes NOTIFY_SOCKET, WATCHDOG_USEC and WATCHDOG_PID from the environment, because workers
  /// must not answer for the daemon. To be called before any thread starts.
  ServiceManager();

  /// Reports that the daemon serves. From now on a thread calls `status` four times in each
  /// watchdog interval; each answer is sent as a watchdog ping, and `systemctl status` shows it.
  /// @param status  receives the time in which it should answer; an empty answer withholds the ping
  void ready(std::function<std::string(Milliseconds)> status);
  /// Reports that the daemon stops; `status` is not called any more.
  void stopping(const std::string& why);

private:
  void send(const std::string& lines) const;
  void report(const std::stop_token& stop, const std::function<std::string(Milliseconds)>& status);

  std::string address_;  ///< of the socket, in the form of the kernel; empty: no manager
  storage::FileDescriptor socket_;
  Milliseconds interval_;
  bool watched_ = false;  ///< the manager expects watchdog pings
  std::jthread reporter_;
};

}  // namespace dccast::daemon
