#include "server/state/backup.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>
#include <vector>

#include "core/storage/file.hpp"
#include "proto/values/digests.hpp"
#include "server/jobs/job_store.hpp"
#include "server/state/store_guard.hpp"
#include "server/studies/study_file.hpp"
#include "server/studies/study_store.hpp"

namespace dccast::state {

namespace {

namespace fs = std::filesystem;

/// Copied in this order; all other files of a job come after them.
constexpr std::array ordered_names{"checkpoint.bin", "journal.bin", "events.log"};

/// Files that are being written and get their names when they are whole.
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

/// @return false when the job was deleted meanwhile
bool copied(const fs::path& from, const fs::path& to) {
  for (int tries = 0; tries < 3; ++tries) {
    try {
      copy_job(from, to);
      return true;
    } catch (const fs::filesystem_error& error) {
      // A file can go between its listing and its copy: an old checkpoint, or the whole job.
      if (error.code() != std::errc::no_such_file_or_directory) throw;
      fs::remove_all(to);
      if (!fs::exists(from)) return false;
    }
  }
  throw std::runtime_error(from.string() + " changes too fast to be copied; try again");
}

/// Syncs the file system of `path` to disk.
void sync_file_system(const fs::path& path) {
  const storage::File directory(path, O_RDONLY | O_DIRECTORY);
  if (::syncfs(directory.descriptor()) != 0)
    throw std::system_error(errno, std::generic_category(), "cannot sync " + path.string());
}

std::string manifest_of(const fs::path& backup) {
  std::vector<std::string> lines;
  for (const auto& entry : fs::recursive_directory_iterator(backup))
    if (entry.is_regular_file())
      lines.push_back(values::sha256_of_file(entry.path()) + "  " +
                      fs::relative(entry.path(), backup).string() + "\n");
  std::ranges::sort(lines, {}, [](const std::string& line) { return line.substr(64); });
  std::string text;
  for (const std::string& line : lines) text += line;
  return text;
}

void require_empty(const fs::path& directory) {
  if (fs::exists(directory) && !fs::is_empty(directory))
    throw std::runtime_error(directory.string() + " is not empty; give a new directory");
}

/// Copies the folders of all jobs in the copied store; forgets those that were deleted meanwhile.
std::size_t copy_jobs(const StateFolder& from, const StateFolder& to) {
  jobs::JobStore store(to.store());
  for (const std::string& id : store.ids())
    if (!copied(from.jobs() / id, to.jobs() / id)) store.erase(id);
  return store.ids().size();
}

/// Copies the files of all studies in the copied store; repairing a restored folder writes those
/// that were removed meanwhile.
void copy_studies(const StateFolder& from, const StateFolder& to) {
  fs::create_directories(to.studies());
  for (const std::string& id : studies::StudyStore(to.store()).ids()) {
    const fs::path file = studies::study_file(from.studies(), id);
    if (fs::exists(file)) fs::copy_file(file, studies::study_file(to.studies(), id));
  }
}

}  // namespace

void back_up(const StateFolder& folder, const fs::path& to, std::ostream& out) {
  if (!fs::exists(folder.store()))
    throw std::runtime_error("there is no job store in " + folder.path().string());
  if (const std::string fault = store_file_fault(folder); !fault.empty())
    throw std::runtime_error(fault + "; " + repair_remedy(folder));
  require_empty(to);
  const StateFolder target(to);
  make_state_folder(target);
  fs::create_directories(target.jobs());
  jobs::JobStore(folder.store()).copy_to(target.store());
  const std::size_t count = copy_jobs(folder, target);
  copy_studies(folder, target);
  if (fs::exists(folder.quarantine())) copy_all(folder.quarantine(), target.quarantine());
  sync_file_system(to);
  storage::replace_file(to / manifest_file, manifest_of(to));
  sync_file_system(to);
  out << count << " jobs copied to " << to.string() << std::endl;
}

}  // namespace dccast::state
