#pragma once

#include <filesystem>
#include <initializer_list>
#include <string_view>

#include "core/storage/file.hpp"

/// Files that survive a crash of the machine whole or not at all. All calls throw StorageError.
namespace dccast::storage {

/// Makes the names in a directory survive a crash.
void sync_directory(const std::filesystem::path& directory);

/// Makes a new file whose content survives a crash; its name does after sync_directory().
void create_durably(const std::filesystem::path& path, std::string_view content);

/// A finished file and the name it is to have, in the same folder.
struct Publication {
  std::filesystem::path finished;
  std::filesystem::path final_path;
};

/// Gives finished files of one folder their final names, in this order, so that after a crash there
/// is either the old file or the whole new one.
void publish(std::initializer_list<Publication> files);

/// Replaces a file by way of `path`.tmp and publish(): readers see the old content or the new,
/// never a part.
void replace_file(const std::filesystem::path& path, std::string_view content,
                  mode_t permissions = owner_only);

}  // namespace dccast::storage
