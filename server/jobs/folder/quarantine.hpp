#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace dccast::jobs {

/// A folder of a job that the store does not know. The daemon never deletes such a folder but moves
/// it to `quarantine/<id>-<time>` beside `jobs/`; `dccastd check` lists it and can restore it.
struct QuarantinedFolder {
  std::string id;  ///< of the job
  std::filesystem::path path;
};

/// The wanted name if it is free, else the first free one with the suffix "-2", "-3", ...
std::filesystem::path free_name(const std::filesystem::path& wanted);

/// Moves one folder of `jobs/` to quarantine. @return its new path @throws std::system_error
std::filesystem::path quarantine_folder(const std::filesystem::path& jobs_directory,
                                        const std::string& id);

/// Moves every folder whose job is not among `known_ids` to quarantine and logs it. Completes
/// removals that a crash has interrupted. @throws std::system_error
void quarantine_unknown_folders(const std::filesystem::path& jobs_directory,
                                const std::set<std::string>& known_ids);

/// The folders in quarantine, the oldest of each job first.
/// @throws std::filesystem::filesystem_error
std::vector<QuarantinedFolder> quarantined_folders(const std::filesystem::path& jobs_directory);

/// Ids of the job folders in `jobs/`. @throws std::filesystem::filesystem_error
std::set<std::string> folder_ids(const std::filesystem::path& jobs_directory);

/// Moves the newest quarantined folder of a job back to `jobs/`. @return false if there is none, or
/// if `jobs/` already holds a folder of that name @throws std::system_error
bool release_folder(const std::filesystem::path& jobs_directory, const std::string& id);

/// First step of deleting a job: renames its folder to `<id>.removed`, which records that deletion
/// was requested. The caller then erases the row and deletes the folder. After a crash in between,
/// quarantine_unknown_folders() restores the name if the row exists, and deletes the folder if not.
/// @return the folder's new name; nothing if there is no folder @throws std::system_error
std::optional<std::filesystem::path> begin_removal(const std::filesystem::path& jobs_directory,
                                                   const std::string& id);

/// Restores the folder's name if the row could not be erased. @throws std::system_error
void undo_removal(const std::filesystem::path& removed);

}  // namespace dccast::jobs
