#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "core/storage/file.hpp"
#include "server/service/connection_watch.hpp"

namespace dccast::service {

/// A TCP socket that listens, and hands on so many connections at a time. It is our own and not
/// gRPC's: an address that is taken gives one line with its reason, and gRPC 1.51 takes whatever
/// comes, up to the last file descriptor, which the daemon would lack for its jobs. When all are
/// in use, the one that has been longest without a request gives way; where each has made one, or a
/// machine has as many as it may, a further connection is closed, which its client sees as
/// UNAVAILABLE.
class Listener {
public:
  /// @param address  host and port; port 0 takes a free one
  /// @throws std::runtime_error  it cannot listen there
  explicit Listener(const std::string& address);
  ~Listener();
  /// Host and port in use.
  const std::string& address() const { return address_; }

  struct Bounds {
    std::size_t connections = 1;
    std::size_t per_peer = SIZE_MAX;  ///< of one machine
    /// What a connection has received before its first request is complete [bytes]: greetings and
    /// the handshake of TLS.
    std::uint64_t greeting_bytes = 0;
    bool over_tls = false;
  };

  /// Begins to accept.
  /// @param admit  takes over the descriptor of a connection; it need not report when it closes it
  void start(const Bounds& bounds, std::function<void(int)> admit);
  /// Accepts no more.
  void stop();

private:
  struct Admitted {
    int descriptor = -1;
    ino_t socket = 0;  ///< behind the descriptor, which may be another's by now
    std::string host;
    std::chrono::steady_clock::time_point since;
  };
  void run();
  void accept_one();
  bool end_a_silent_one(const std::string& host);
  bool has_room(const std::string& host);
  void pace();
  void trim();

  storage::FileDescriptor socket_;
  std::string address_;
  const storage::FileDescriptor ended_;
  Bounds bounds_;
  std::function<void(int)> admit_;
  std::vector<Admitted> admitted_;  ///< oldest first
  bool full_ = false;
  bool trim_is_due_ = false;
  const EndedConnections hostile_ = std::make_shared<std::atomic<int>>(0);  ///< since the last pace
  std::thread thread_;
};

}  // namespace dccast::service
