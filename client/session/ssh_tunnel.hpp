#pragma once

#include <sys/types.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "client/session/failure.hpp"

namespace dccast::client {

/// A way to a daemon through the user's own ssh: "ssh://[USER@]HOST[:SSH_PORT][/PATH]", where PATH
/// is that of the daemon's Unix socket there, which for a service may be left out. One ssh forwards
/// connections to it, with the user's keys, settings and known hosts, and is started again when it
/// ends; it does not outlive this process. Our end is a socket in a folder of this user's alone.
class SshTunnel {
public:
  static bool is_meant(const std::string& server) { return server.starts_with("ssh://"); }
  /// @throws CommandFailed  another text, or there is no place for the socket
  explicit SshTunnel(const std::string& server);
  SshTunnel(const SshTunnel&) = delete;
  /// Ends ssh and removes its folder.
  ~SshTunnel();

  /// Starts ssh, and returns once it has logged in.
  /// @throws CommandFailed  it ended before that; it has said why
  void open();
  /// Starts ssh, and sends a greeting to the daemon.
  /// @param timeout  of ssh for reaching the machine; four times that for all, as a person may have
  ///                 to enter something
  /// @param answer   set to the first bytes that came back, at most 64
  /// @return         why there is no answer: ssh itself, or what it found on the other machine
  Diagnosis open_and_greet(const std::string& greeting, std::chrono::milliseconds timeout,
                           std::string& answer);

  /// For gRPC.
  std::string address() const { return "unix:" + socket_.string(); }
  /// "/run/dccast/dccastd.sock", as the other machine sees it.
  const std::string& target() const { return target_; }

private:
  using Clock = std::chrono::steady_clock;
  /// Outcome of ssh's login: it makes the socket once it has logged in.
  enum class Login { made, failed, timed_out };

  /// Starts ssh in a thread that waits for its end.
  void start();
  /// Of the thread that owns the ssh processes.
  void run();
  /// Keeps why ssh has ended. @param wait_status  as of waitpid()
  void note_end(int wait_status);
  /// Waits until the forwarded socket exists or ssh has ended.
  Login wait_for_login(Clock::time_point end);
  /// A socket that is connected to ssh's; not connected if ssh does not listen until `end`.
  int connect_to_socket(Clock::time_point end) const;
  /// Sends a greeting through the tunnel. @return the first bytes of the answer; empty if there are
  /// none
  std::string greet(const std::string& greeting, Clock::time_point end) const;

  std::string login_;  ///< "ssh -p 2222 anna@casthouse", as a person would type it
  std::string target_;
  std::filesystem::path socket_, messages_;
  std::vector<std::string> command_;
  int errors_;        ///< what ssh writes its messages to
  int leaving_ = -1;  ///< eventfd
  std::atomic<bool> has_logged_in_ = false;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<int> exit_code_;  ///< of the ssh that ended last; 127: it cannot be started
  std::thread thread_;
};

}  // namespace dccast::client
