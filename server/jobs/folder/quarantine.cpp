#include "server/jobs/folder/quarantine.hpp"

#include <fmt/chrono.h>

#include <algorithm>
#include <ctime>

#include "core/storage/file.hpp"
#include "proto/values/digests.hpp"
#include "server/jobs/log.hpp"

namespace dccast::jobs {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t id_length = 36;  // of a UUID
constexpr std::string_view removed_suffix = ".removed";

/// A rename that survives a crash of the machine.
void move(const fs::path& from, const fs::path& to) {
  fs::rename(from, to);
  storage::sync_directory(to.parent_path());
  if (from.parent_path() != to.parent_path()) storage::sync_directory(from.parent_path());
}

/// Names in a directory, sorted; none when there is no such directory, or something else in its
/// place.
std::vector<std::string> names_in(const fs::path& directory) {
  std::vector<std::string> names;
  if (!fs::is_directory(directory)) return names;
  for (const auto& entry : fs::directory_iterator(directory))
    names.push_back(entry.path().filename());
  std::ranges::sort(names);
  return names;
}

fs::path quarantine_path(const fs::path& jobs_directory) {
  return fs::absolute(jobs_directory).parent_path() / "quarantine";
}

void end_removals(const fs::path& jobs_directory, const std::set<std::string>& known_ids) {
  for (const std::string& name : names_in(jobs_directory)) {
    if (!name.ends_with(removed_suffix)) continue;
    const std::string id = name.substr(0, name.size() - removed_suffix.size());
    if (!values::is_uuid(id)) continue;

    // With a row the deletion did not happen; without one only the folder is left to delete.
    if (known_ids.contains(id)) {
      undo_removal(jobs_directory / name);
    } else {
      log::info("job {}: deleting its folder, as requested before the restart", id);
      fs::remove_all(jobs_directory / name);
    }
  }
}

}  // namespace

fs::path free_name(const fs::path& wanted) {
  fs::path name = wanted;
  for (int number = 2; fs::exists(name); ++number)
    name = fmt::format("{}-{}", wanted.string(), number);
  return name;
}

fs::path quarantine_folder(const fs::path& jobs_directory, const std::string& id) {
  const fs::path quarantine = quarantine_path(jobs_directory);
  if (fs::exists(quarantine) && !fs::is_directory(quarantine)) {
    const fs::path aside = free_name(quarantine.string() + ".strange");
    move(quarantine, aside);
    log::warn("{} is no folder; it was moved to {}", quarantine.string(), aside.string());
  }
  if (fs::create_directories(quarantine)) {
    fs::permissions(quarantine, fs::perms::owner_all);
    storage::sync_directory(quarantine.parent_path());
  }

  const fs::path target = free_name(
      quarantine / fmt::format("{}-{:%Y%m%dT%H%M%SZ}", id, fmt::gmtime(std::time(nullptr))));
  move(jobs_directory / id, target);
  return target;
}

void quarantine_unknown_folders(const fs::path& jobs_directory,
                                const std::set<std::string>& known_ids) {
  end_removals(jobs_directory, known_ids);

  for (const std::string& id : folder_ids(jobs_directory))
    if (!known_ids.contains(id))
      log::warn("job {}: not in the store; its folder was moved to {}; dccastd check lists it", id,
                quarantine_folder(jobs_directory, id).string());
}

std::vector<QuarantinedFolder> quarantined_folders(const fs::path& jobs_directory) {
  const fs::path quarantine = quarantine_path(jobs_directory);
  std::vector<QuarantinedFolder> folders;
  for (const std::string& name : names_in(quarantine))
    if (const std::string id = name.substr(0, id_length); values::is_uuid(id))
      folders.push_back({id, quarantine / name});
  return folders;
}

std::set<std::string> folder_ids(const fs::path& jobs_directory) {
  std::set<std::string> ids;
  for (const std::string& name : names_in(jobs_directory))
    if (values::is_uuid(name)) ids.insert(name);
  return ids;
}

bool release_folder(const fs::path& jobs_directory, const std::string& id) {
  if (fs::exists(jobs_directory / id)) return false;

  const auto folders = quarantined_folders(jobs_directory);
  const auto newest = std::find_if(folders.rbegin(), folders.rend(),
                                   [&](const QuarantinedFolder& each) { return each.id == id; });
  if (newest == folders.rend()) return false;

  move(newest->path, jobs_directory / id);
  return true;
}

std::optional<fs::path> begin_removal(const fs::path& jobs_directory, const std::string& id) {
  if (!fs::exists(jobs_directory / id)) return std::nullopt;
  fs::path removed = jobs_directory / (id + std::string(removed_suffix));
  move(jobs_directory / id, removed);
  return removed;
}

void undo_removal(const fs::path& removed) {
  fs::path folder = removed;
  move(removed, folder.replace_extension());
}

}  // namespace dccast::jobs
