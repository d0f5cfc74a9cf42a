#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/restart/sections.hpp"

namespace dccast::restart {

/// Result of reading a checkpoint: the content, or the reason why there is none.
struct [[nodiscard]] CheckpointRead {
  std::optional<Sections> content;
  /// "", "missing", "truncated", "checksum", "not a checkpoint", or the format it has
  std::string reason;
  bool other_format =
      false;  ///< the file follows another version of CHECKPOINT.md and was not checked
};

/// Writes a checkpoint atomically: after a crash either the previous one or the complete new one
/// exists. The format is CHECKPOINT.md. @throws storage::StorageError
void write_checkpoint(const std::filesystem::path& path, const Sections& content);

/// Damaged content is never an exception: a run without a readable checkpoint starts from the
/// beginning.
/// @throws storage::StorageError  the file is there but cannot be read (permission, disk)
CheckpointRead read_checkpoint(const std::filesystem::path& path);

}  // namespace dccast::restart
