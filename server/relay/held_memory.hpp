#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace dccast::relay {

/// Bounds on the memory of unfinished requests [bytes].
struct MemoryBounds {
  /// Of all connections together.
  std::size_t all = 0;
  std::size_t of_user = 0;       ///< one user
  std::size_t of_strangers = 0;  ///< all unauthenticated clients
  std::size_t of_machine = 0;    ///< unauthenticated clients of one machine
  /// Content of one call that gRPC holds at most: it reads on only when the handler has taken what
  /// has arrived.
  std::size_t of_call = SIZE_MAX;
};

/// Memory of the unfinished requests of one connection.
struct HeldMemory {
  std::string user{};  ///< empty if unauthenticated
  std::string machine;
  /// Memory of its unfinished requests.
  std::size_t bytes = 0;
};

/// Checks unauthenticated clients and single users before the total, so that no one can end the
/// upload of another. @return index of the connection to end; empty if all are within the bounds
std::optional<std::size_t> beyond_bounds(const std::vector<HeldMemory>& connections,
                                         const MemoryBounds& bounds);

}  // namespace dccast::relay
