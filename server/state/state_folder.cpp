#include "server/state/state_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <map>
#include <set>
#include <sstream>
#include <system_error>

#include "core/storage/file.hpp"
#include "proto/values/digests.hpp"
#include "server/jobs/folder/format.hpp"
#include "server/jobs/folder/job_description.hpp"
#include "server/jobs/folder/quarantine.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/store/job_store.hpp"
#include "server/state/check.hpp"
#include "server/state/index.hpp"
#include "server/studies/lines.hpp"
#include "server/studies/study_file.hpp"
#include "server/studies/study_store.hpp"

namespace dccast::state {

namespace {

namespace fs = std::filesystem;

/// If a daemon is killed while it starts a process, that process inherits the lock and releases it
/// as soon as it runs, which takes seconds on a busy machine.
constexpr std::chrono::seconds longest_wait{3};

/// The list of a backup's files with their SHA-256, in the format of sha256sum(1). It is written
/// last: a backup without it is incomplete.
constexpr const char* manifest_file = "MANIFEST.sha256";
using Manifest = std::map<std::string, std::string>;  ///< SHA-256 by file

/// Copied in this order; all other files of a job come after them.
constexpr std::array ordered_names{"checkpoint.bin", "journal.bin", "events.log"};

/// Whether a file is still being written; it gets its final name when it is complete.
bool is_unfinished(const fs::path& file) {
  constexpr std::array extensions{".part", ".tmp", ".next"};
  return std::ranges::find(extensions, file.extension()) != extensions.end();
}

void copy_all(const fs::path& from, const fs::path& to) {
  fs::create_directories(to);
  for (const auto& entry : fs::directory_iterator(from)) {
    const fs::path target = to / entry.path().filename();
    if (entry.is_directory())
      copy_all(entry.path(), target);
    else if (!is_unfinished(entry.path()) && !fs::exists(target))
      fs::copy_file(entry.path(), target);
  }
}

void copy_job(const fs::path& from, const fs::path& to) {
  fs::create_directories(to);
  for (const char* name : ordered_names)
    if (fs::exists(from / name)) fs::copy_file(from / name, to / name);
  copy_all(from, to);
}

/// Copies the folder of a job. @return false if the job was deleted meanwhile
bool try_copy_job(const fs::path& from, const fs::path& to) {
  for (int tries = 0; tries < 3; ++tries) {
    try {
      copy_job(from, to);
      return true;
    } catch (const fs::filesystem_error& error) {
      // A file may be removed between its listing and its copy: an old checkpoint, or the whole
      // job.
      if (error.code() != std::errc::no_such_file_or_directory) throw;
      fs::remove_all(to);
      if (!fs::exists(from)) return false;
    }
  }
  throw std::runtime_error(
      fmt::format("{} changes too fast to be copied; try again", from.string()));
}

/// Syncs the file system of `path` to disk.
void sync_file_system(const fs::path& path) {
  const storage::File directory(path, O_RDONLY | O_DIRECTORY);
  if (::syncfs(directory.descriptor()) != 0)
    throw std::system_error(errno, std::generic_category(),
                            fmt::format("cannot sync {}", path.string()));
}

Manifest make_manifest(const fs::path& backup) {
  Manifest manifest;
  for (const auto& entry : fs::recursive_directory_iterator(backup))
    if (entry.is_regular_file())
      manifest[fs::relative(entry.path(), backup)] = values::sha256_of_file(entry.path());
  return manifest;
}

/// Accepted jobs without a row. A running daemon may accept jobs meanwhile, and writes the row
/// before the mark, so the rows are read again after the folders.
std::set<std::string> lost_beside_daemon(const StateFolder& folder) {
  jobs::JobStore store(folder.store());
  auto lost = lost_jobs(folder, store.ids());
  const auto known = store.ids();
  std::erase_if(lost, [&](const std::string& id) { return known.contains(id); });
  return lost;
}

/// Refuses a store with lost rows, because the backup would lack these jobs.
void require_whole_store(const StateFolder& folder) {
  const auto lost = lost_beside_daemon(folder);
  if (lost.empty()) return;

  throw std::runtime_error(fmt::format(
      "the job store {} lacks {} jobs, e.g. {}; nothing was changed: restore a backup, or rebuild "
      "the store from the job folders with dccastd check --repair --set data_directory={}",
      folder.store().string(), lost.size(), *lost.begin(), folder.path().string()));
}

/// Copies the folders of all jobs in the copied store, and erases the rows of those that were
/// deleted meanwhile. @return number of jobs
std::size_t copy_jobs(const StateFolder& from, const StateFolder& to) {
  jobs::JobStore store(to.store());
  for (const std::string& id : store.ids())
    if (!try_copy_job(from.jobs() / id, to.jobs() / id)) store.erase(id);
  return store.ids().size();
}

/// Copies the files of all studies in the copied store. Those that were removed meanwhile are
/// written again when the restored folder is repaired.
void copy_studies(const StateFolder& from, const StateFolder& to) {
  fs::create_directories(to.studies());
  for (const std::string& id : studies::StudyStore(to.store()).ids()) {
    const fs::path file = studies::study_file(from.studies(), id);
    if (fs::exists(file)) fs::copy_file(file, studies::study_file(to.studies(), id));
    const fs::path attachments = studies::attachments_of_study(from.studies(), id);
    if (fs::exists(attachments))
      copy_all(attachments, studies::attachments_of_study(to.studies(), id));
  }
}

/// Copies users, certificates and the audit log (server/access). These files are only replaced as a
/// whole or appended to, so a copy is consistent.
void copy_access(const StateFolder& from, const StateFolder& to) {
  for (const char* name : {"users.toml", "audit.log"})
    if (fs::exists(from.path() / name)) fs::copy_file(from.path() / name, to.path() / name);
  if (fs::exists(from.path() / "pki")) copy_all(from.path() / "pki", to.path() / "pki");
}

Manifest read_manifest(const fs::path& backup) {
  if (!fs::exists(backup / manifest_file))
    throw std::runtime_error(fmt::format("{} has no {}: it is not a backup, or an incomplete one",
                                         backup.string(), manifest_file));

  constexpr std::size_t sha256_length = 64;               // [characters]
  constexpr std::size_t name_column = sha256_length + 2;  // after two spaces
  std::istringstream text(storage::read_file(backup / manifest_file));
  Manifest manifest;
  for (std::string line; std::getline(text, line);)
    if (line.size() > name_column)
      manifest[line.substr(name_column)] = line.substr(0, sha256_length);
  return manifest;
}

/// Replaces files by hard links to those of an earlier backup that have the same content.
/// @return their number
std::size_t link_to_earlier(const fs::path& backup, const Manifest& files, const fs::path& earlier,
                            const Manifest& earlier_files) {
  std::size_t linked = 0;
  for (const auto& [file, sha256] : files) {
    const auto same = earlier_files.find(file);
    if (same == earlier_files.end() || same->second != sha256) continue;
    if (values::sha256_of_file(earlier / file) != sha256) continue;  // damaged since

    fs::path link = backup / file;
    link += ".link";
    fs::create_hard_link(earlier / file, link);
    fs::rename(link, backup / file);
    ++linked;
  }
  return linked;
}

/// Copies one file and compares the copy with the manifest.
void copy_verified(const fs::path& file, const std::string& sha256, const fs::path& from,
                   const fs::path& to) {
  if (file.is_absolute() || file.lexically_normal().string().starts_with(".."))
    throw std::runtime_error(
        fmt::format("the manifest names {}, outside the backup", file.string()));

  fs::create_directories((to / file).parent_path());
  fs::copy_file(from / file, to / file);
  if (values::sha256_of_file(to / file) != sha256)
    throw std::runtime_error(fmt::format("{} is damaged: its SHA-256 is not the one in {}",
                                         (from / file).string(), manifest_file));
}

}  // namespace

StateLock::StateLock(const StateFolder& folder) : lock_(folder.lock(), longest_wait) {
  if (!lock_)
    throw std::runtime_error(
        fmt::format("another dccastd uses the data directory {}; stop it, or set another "
                    "data_directory",
                    folder.path().string()));
}

void require_data_format(const StateFolder& folder) {
  const auto check = [](const fs::path& file, const fs::path& subject, std::string_view kind) {
    if (storage::kind_of_entry(file) != storage::regular_file) return;  // missing or damaged
    std::string header(jobs::file_header(kind).size(), '\0');
    header.resize(storage::File(file, O_RDONLY).read_at(0, header));
    jobs::require_data_format(subject, header, kind);
  };

  for (const std::string& id : jobs::folder_ids(folder.jobs()))
    check(folder.jobs() / id / jobs::description_file, folder.jobs() / id, jobs::description_kind);
  for (const std::string& id : studies::ids_of_study_files(folder.studies()))
    check(studies::study_file(folder.studies(), id), studies::study_file(folder.studies(), id),
          studies::study_file_kind);

  if (!fs::is_directory(folder.lines())) return;
  for (const auto& line : fs::directory_iterator(folder.lines()))
    check(line.path(), line.path(), studies::line_file_kind);
}

void set_strange_folders_aside(const StateFolder& folder) {
  for (const fs::path& path : {folder.studies(), folder.lines(), folder.uploads()}) {
    const std::string kind = storage::kind_of_entry(path);
    if (kind.empty() || fs::is_directory(path)) continue;
    fs::path aside = path;
    aside += ".aside";
    fs::rename(path, aside);
    log::warn("{} is {}, not a folder; it was moved to {}", path.string(), kind, aside.string());
  }
}

void make_state_folder(const StateFolder& folder) {
  std::filesystem::create_directories(folder.path());
  std::filesystem::permissions(folder.path(), std::filesystem::perms::owner_all);
}

void back_up(const StateFolder& folder, const fs::path& to, const fs::path& earlier,
             std::ostream& out) {
  if (storage::kind_of_entry(folder.store()).empty())
    throw std::runtime_error(fmt::format("there is no job store in {}", folder.path().string()));
  require_whole_store(folder);
  if (fs::exists(to) && !fs::is_empty(to))
    throw std::runtime_error(fmt::format("{} is not empty; give a new directory", to.string()));
  const Manifest earlier_files = earlier.empty() ? Manifest() : read_manifest(earlier);

  require_data_format(folder);
  const StateFolder target(to);
  make_state_folder(target);
  fs::create_directories(target.jobs());

  // The store first: see the header.
  jobs::JobStore(folder.store()).copy_to(target.store());
  const std::size_t count = copy_jobs(folder, target);
  copy_studies(folder, target);
  if (fs::exists(folder.lines())) copy_all(folder.lines(), target.lines());
  copy_access(folder, target);
  if (fs::exists(folder.quarantine())) copy_all(folder.quarantine(), target.quarantine());

  const Manifest files = make_manifest(to);
  const std::size_t linked = link_to_earlier(to, files, earlier, earlier_files);

  // The manifest declares the backup complete, so everything else must be on the disk before it.
  sync_file_system(to);
  std::string manifest;
  for (const auto& [file, sha256] : files) manifest += fmt::format("{}  {}\n", sha256, file);
  storage::replace_file(to / manifest_file, manifest);
  sync_file_system(to);

  out << count << " jobs copied to " << to.string();
  if (!earlier.empty())
    out << ", " << linked << " of its files linked to those of " << earlier.string();
  out << std::endl;
}

int restore(const StateFolder& folder, const fs::path& from, std::ostream& out) {
  const Manifest manifest = read_manifest(from);
  require_data_format(StateFolder(from));
  make_state_folder(folder);
  {
    const StateLock lock(folder);
    if (!storage::kind_of_entry(folder.store()).empty() || fs::exists(folder.jobs()))
      throw std::runtime_error(
          fmt::format("the data directory {} has jobs; set another data_directory, or move them "
                      "away",
                      folder.path().string()));

    for (const auto& [file, sha256] : manifest) copy_verified(file, sha256, from, folder.path());
    fs::create_directories(folder.jobs());
  }
  out << manifest.size() << " files restored to " << folder.path().string() << std::endl;
  return check(folder, {.repair = true, .deep = false, .adopt = {}}, out);
}

}  // namespace dccast::state
