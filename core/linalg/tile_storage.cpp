#include "core/linalg/tile_storage.hpp"

#ifdef __linux__
#include <sys/mman.h>
#endif

#include <cstdlib>
#include <new>

namespace dccast::linalg {

namespace {

constexpr std::size_t huge_page = std::size_t(2) << 20;  // [byte]

Tile* allocate(std::size_t tiles) {
  const std::size_t bytes = tiles * sizeof(Tile);
  if (bytes < cache_bytes) return static_cast<Tile*>(std::aligned_alloc(alignof(Tile), bytes));
  const std::size_t whole = (bytes + huge_page - 1) / huge_page * huge_page;
  void* storage = std::aligned_alloc(huge_page, whole);
#ifdef MADV_HUGEPAGE
  if (storage != nullptr) madvise(storage, whole, MADV_HUGEPAGE);
#endif
  return static_cast<Tile*>(storage);
}

}  // namespace

void TileStorage::reserve(std::size_t tiles) {
  if (tiles <= capacity_) return;
  const std::size_t room = capacity_ == 0 ? tiles : tiles + tiles / 4;
  capacity_ = 0;
  tile_.reset();
  tile_.reset(allocate(room));
  if (tile_ == nullptr) throw std::bad_alloc();
  capacity_ = room;
}

void TileStorage::Free::operator()(Tile* tiles) const {
  std::free(tiles);
}

}  // namespace dccast::linalg
