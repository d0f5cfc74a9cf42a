#pragma once

#include <filesystem>
#include <initializer_list>
#include <string_view>

#include "core/storage/file.hpp"

/// Files that survive a crash of the machine completely or not at all. All calls throw
/// StorageError.
namespace dccast::storage {

/// Syncs a directory, so that the names in it survive a crash.
void sync_directory(const std::filesystem::path& directory);

/// Creates a file whose content survives a crash; its name survives after sync_directory().
void create_durably(const std::filesystem::path& path, std::string_view content);

/// A finished file and its final name, in the same folder.
struct Publication {
  std::filesystem::path finished;
  std::filesystem::path final_path;
};

/// Renames finished files of one folder to their final names, in this order, so that after a crash
/// either the old file or the complete new one exists.
void publish(std::initializer_list<Publication> files);

/// Replaces a file by `path`.tmp and publish(): readers see the old or the new content, never a
/// part of it.
void replace_file(const std::filesystem::path& path, std::string_view content,
                  mode_t permissions = owner_only);

}  // namespace dccast::storage
