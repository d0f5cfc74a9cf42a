#pragma once

#include <sys/types.h>

#include <cstddef>
#include <functional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/storage/file.hpp"

namespace dccast::service {

/// Whether clients on other machines cannot reach this address ("127.0.0.1:0", "[::1]:7117",
/// "localhost:7117").
bool is_loopback(const std::string& address);

/// A TCP socket that listens, and hands on so many connections at a time. It is our own and not
/// gRPC's: an address that is taken gives one line with its reason, and gRPC 1.51 takes whatever
/// comes, up to the last file descriptor, which the daemon would lack for its jobs. Further
/// connections are closed, which their clients see as UNAVAILABLE.
class Listener {
public:
  /// @param address  host and port; port 0 takes a free one
  /// @throws std::runtime_error  it cannot listen there
  explicit Listener(const std::string& address);
  ~Listener();
  /// Host and port in use.
  const std::string& address() const { return address_; }

  /// Begins to accept.
  /// @param admit  takes over the descriptor of a connection; it need not report when it closes it
  void start(std::size_t maximum_connections, std::function<void(int)> admit);
  /// Accepts no more.
  void stop();

private:
  void run();
  void accept_one();
  std::size_t count_open();

  storage::FileDescriptor socket_;
  std::string address_;
  const storage::FileDescriptor ended_;
  std::size_t maximum_connections_ = 0;
  std::function<void(int)> admit_;
  std::vector<std::pair<int, ino_t>> admitted_;  ///< descriptor and socket behind it
  bool full_ = false;
  std::thread thread_;
};

}  // namespace dccast::service
