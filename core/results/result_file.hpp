#pragma once

#include <string>

/// Names in results.h5, shared by writer, reader and sidecar. SCHEMA.md is the specification.
namespace dccast::results {

/// Incremented when a dataset changes or is removed, not when one is added.
inline constexpr int schema_version = 2;

/// "/frames/000012"
std::string frame_group(std::size_t index);
/// "/history/time_s"
inline std::string history_dataset(const std::string& field) {
  return std::string("/history/") + field;
}

}  // namespace dccast::results
