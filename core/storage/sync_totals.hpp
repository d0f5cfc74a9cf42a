#pragma once

#include <cstdint>

namespace dccast::storage {

/// How often this process has synced files and directories, and how long it has waited for that.
struct SyncTotals {
  std::uint64_t count = 0;
  double seconds = 0.0;
};
SyncTotals sync_totals();

}  // namespace dccast::storage
