#pragma once

#include <string>

/// Names inside results.h5, in one place for writer, reader and sidecar. The contract is SCHEMA.md.
namespace dccast::results {

/// Raised when a dataset changes or goes; new datasets do not raise it.
inline constexpr int schema_version = 1;

/// "/frames/000012"
std::string frame_group(std::size_t index);
/// "/history/time_s"
inline std::string history_dataset(const char* field) {
  return std::string("/history/") + field;
}

}  // namespace dccast::results
