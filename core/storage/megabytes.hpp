#pragma once

#include <cstdint>
#include <string>

namespace dccast::storage {

/// A size as text, e.g. "120 MB", rounded down. @param bytes  [bytes], not negative
inline std::string megabytes(std::int64_t bytes) {
  return std::to_string(bytes / 1000000) + " MB";
}

}  // namespace dccast::storage
