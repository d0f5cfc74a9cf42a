#pragma once

#include <sys/types.h>

#include <cstddef>
#include <functional>
#include <thread>
#include <utility>
#include <vector>

#include "core/storage/file.hpp"

namespace dccast::service {

/// Accepts connections and hands them on, so many at a time: gRPC 1.51 takes whatever comes, up to
/// the last file descriptor, and with those the daemon would lack them for its jobs. Further ones
/// are closed, which their clients see as UNAVAILABLE.
class Door {
public:
  /// @param listening  outlives this object
  /// @param admit      takes over the descriptor of a connection; it need not say when it closes it
  Door(int listening, std::size_t maximum_connections, std::function<void(int)> admit);
  /// Accepts no more.
  ~Door();

private:
  void run();
  void accept_one();
  std::size_t count_open();

  const int listening_;
  const std::size_t maximum_connections_;
  const std::function<void(int)> admit_;
  const storage::FileDescriptor ended_;
  std::vector<std::pair<int, ino_t>> admitted_;  ///< descriptor and socket behind it
  bool full_ = false;
  std::thread thread_;
};

}  // namespace dccast::service
