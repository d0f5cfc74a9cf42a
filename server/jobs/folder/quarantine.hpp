#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace dccast::jobs {

/// Folders of jobs the store does not know. The daemon never deletes one: it is moved to
/// `quarantine/<id>-<time>` beside `jobs/`, where `dccastd check` lists it and can bring it back.
struct QuarantinedFolder {
  std::string id;  ///< of the job
  std::filesystem::path path;
};

/// A name that is not taken: the one that is wanted, else with "-2", "-3" ... behind it.
std::filesystem::path free_name(const std::filesystem::path& wanted);

/// Moves one folder of `jobs/` aside. @return where it is now @throws std::system_error
std::filesystem::path quarantine_folder(const std::filesystem::path& jobs_directory,
                                        const std::string& id);

/// Moves every folder of a job that is not among `known_ids` aside, which the log reports; ends
/// removals that a crash cut short. @throws std::system_error
void quarantine_unknown_folders(const std::filesystem::path& jobs_directory,
                                const std::set<std::string>& known_ids);

/// What is in quarantine, oldest first within a job. @throws std::filesystem::filesystem_error
std::vector<QuarantinedFolder> quarantined_folders(const std::filesystem::path& jobs_directory);

/// Ids of the job folders in `jobs/`. @throws std::filesystem::filesystem_error
std::set<std::string> folder_ids(const std::filesystem::path& jobs_directory);

/// Brings the newest folder of this job back to `jobs/`. @return false when there is none, or
/// `jobs/` has a folder of that name @throws std::system_error
bool release_folder(const std::filesystem::path& jobs_directory, const std::string& id);

/// First half of deleting a job: its folder gets the name `<id>.removed`, which marks that deletion
/// was asked for. Then erase the row, then delete the folder. A crash in between is put right by
/// quarantine_unknown_folders(): with a row the folder gets its name back, without one it is
/// deleted.
/// @return the folder's new name; nothing when there is no folder @throws std::system_error
std::optional<std::filesystem::path> begin_removal(const std::filesystem::path& jobs_directory,
                                                   const std::string& id);

/// Gives the folder its name back, when the row could not be erased. @throws std::system_error
void undo_removal(const std::filesystem::path& removed);

}  // namespace dccast::jobs
