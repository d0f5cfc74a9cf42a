#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/restart/sections.hpp"

namespace dccast::restart {

/// What reading a checkpoint came to: the content, or why there is none.
struct CheckpointRead {
  std::optional<Sections> content;
  /// "", "missing", "truncated", "checksum", "not a checkpoint", or which format it is of
  std::string reason;
  bool other_format = false;  ///< whole, perhaps, but of another version of CHECKPOINT.md
};

/// Writes a checkpoint so that after a crash there is the previous one or the whole new one.
/// The format is CHECKPOINT.md. @throws storage::StorageError
void write_checkpoint(const std::filesystem::path& path, const Sections& content);

/// Never throws for what is in the file; a run without a readable checkpoint starts over.
/// @throws storage::StorageError  the file is there but cannot be read (permission, disk)
CheckpointRead read_checkpoint(const std::filesystem::path& path);

}  // namespace dccast::restart
