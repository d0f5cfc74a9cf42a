#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "client/session/failure.hpp"

namespace dccast::client {

/// A way to a daemon through the user's own ssh: "ssh://[USER@]HOST[:SSH_PORT][/PORT]", where PORT
/// is that of dccastd on loopback there (7117). Each connection to `address()` is one `ssh -W`,
/// with the user's keys, settings and known hosts; it ends with the connection. The socket lies in
/// a folder of this user's alone.
class SshTunnel {
public:
  static bool is_meant(const std::string& server) { return server.starts_with("ssh://"); }
  /// @throws CommandFailed  another text, or there is no place for the socket
  explicit SshTunnel(const std::string& server);
  ~SshTunnel();
  /// For gRPC.
  std::string address() const { return "unix:" + socket_.string(); }

  /// "127.0.0.1:7117", as the other machine sees it.
  const std::string& target() const;
  /// Sends a greeting to the daemon by one ssh of its own.
  /// @param timeout  of ssh for reaching the machine; four times that for all, as a person may have
  ///                 to enter something
  /// @param answer   set to the first bytes that came back, at most 64
  /// @return         why there is no answer: ssh itself, or what it found on the other machine
  Diagnosis try_once(const std::string& greeting, std::chrono::milliseconds timeout,
                     std::string& answer) const;

private:
  void run();
  void connect(int connection);
  void reap(bool all);

  std::vector<std::string> command_;
  std::filesystem::path socket_;
  int listener_ = -1;
  int ended_ = -1;  ///< eventfd
  std::vector<int> processes_;
  std::thread thread_;
};

}  // namespace dccast::client
