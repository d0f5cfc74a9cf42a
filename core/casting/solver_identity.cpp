#include "core/casting/solver_identity.hpp"

#include "core/linalg/tile_kernels.hpp"

namespace dccast::casting {

extern const char core_sources[];  // written by hash_sources.cmake when a source has changed

const std::string& solver_identity() {
  static const std::string identity = std::string("dccast ") + DCCAST_VERSION + ", g++ " +
                                      __VERSION__ + ", " + linalg::best_tile_kernels().name +
                                      ", state 3, sources " + core_sources;
  return identity;
}

}  // namespace dccast::casting
