#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace dccast::relay {

/// How much requests may hold that are not finished [bytes].
struct MemoryBounds {
  std::size_t all = 0;
  std::size_t of_user = 0;       ///< one user
  std::size_t of_strangers = 0;  ///< all who have not shown who they are
  std::size_t of_machine = 0;    ///< strangers of one machine
  /// What gRPC holds of the content of one call at most: it reads no further before the call takes
  /// what has come.
  std::size_t of_call = SIZE_MAX;
};

/// What the unfinished requests of one connection hold.
struct HeldMemory {
  std::string user{};  ///< empty: a stranger
  std::string machine;
  std::size_t bytes = 0;
};

/// Bounds strangers and users before the total, so that no one ends the upload of another.
/// @return index of the connection to be ended; nothing: all are within their bounds
std::optional<std::size_t> beyond_bounds(const std::vector<HeldMemory>& connections,
                                         const MemoryBounds& bounds);

}  // namespace dccast::relay
