#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/results/sections.hpp"

namespace dccast::results {

/// Result of reading a checkpoint: the content, or the reason why there is none.
struct [[nodiscard]] CheckpointRead {
  /// Absent if the file is missing or damaged.
  std::optional<Sections> content;
  /// "", "missing", "truncated", "checksum", "not a checkpoint", or the format it has
  std::string reason;
  /// The file follows another version of CHECKPOINT.md and was not checked.
  bool other_format = false;
};

/// Writes a checkpoint atomically: after a crash either the previous one or the complete new one
/// exists. The format is CHECKPOINT.md. @throws storage::StorageError
void write_checkpoint(const std::filesystem::path& path, const Sections& content);

/// Reads a checkpoint. Damaged content is not an exception: a run without a readable checkpoint
/// starts from the beginning.
/// @throws storage::StorageError  the file is there but cannot be read (permission, disk)
CheckpointRead read_checkpoint(const std::filesystem::path& path);

}  // namespace dccast::results
