#pragma once

#include <cstddef>
#include <memory>

#include "core/linalg/tile_kernels.hpp"

namespace dccast::linalg {

/// A factor larger than this is no longer in the cache when a solve needs it [byte]. Measured, see
/// docs/factorisation.md.
inline constexpr std::size_t cache_bytes = std::size_t(8) << 20;

/// Uninitialised storage for the tiles of a factor, in huge pages if it is large: a solve reads all
/// of it.
class TileStorage {
public:
  /// Reserves memory for a number of tiles; the content is lost if the storage has to grow. It
  /// grows with a reserve for a few rows of cells: touching new memory costs more than a
  /// factorisation.
  /// @throws std::bad_alloc
  void reserve(std::size_t tiles);

  Tile* get() const { return tile_.get(); }
  Tile& operator[](std::size_t i) const { return tile_[i]; }
  std::size_t bytes() const { return capacity_ * sizeof(Tile); }

private:
  struct Free {
    void operator()(Tile* tiles) const;
  };
  std::unique_ptr<Tile[], Free> tile_;
  std::size_t capacity_ = 0;
};

}  // namespace dccast::linalg
