#include <sstream>

#include "core/storage/file.hpp"
#include "proto/values/digests.hpp"
#include "server/state/backup.hpp"
#include "server/state/check.hpp"

namespace dccast::state {

namespace {

namespace fs = std::filesystem;

struct ManifestLine {
  std::string sha256;
  fs::path file;
};

std::vector<ManifestLine> read_manifest(const fs::path& backup) {
  if (!fs::exists(backup / manifest_file))
    throw std::runtime_error(backup.string() + " has no " + manifest_file +
                             ": it is no backup, or one that did not come to its end");
  std::istringstream text(storage::read_file(backup / manifest_file));
  std::vector<ManifestLine> lines;
  for (std::string line; std::getline(text, line);)
    if (line.size() > 66) lines.push_back({line.substr(0, 64), line.substr(66)});
  return lines;
}

/// Copies one file and holds the copy against the manifest.
void copy_verified(const ManifestLine& line, const fs::path& from, const fs::path& to) {
  if (line.file.is_absolute() || line.file.lexically_normal().string().starts_with(".."))
    throw std::runtime_error("the manifest names " + line.file.string() + ", outside the backup");
  fs::create_directories((to / line.file).parent_path());
  fs::copy_file(from / line.file, to / line.file);
  if (values::sha256_of_file(to / line.file) != line.sha256)
    throw std::runtime_error((from / line.file).string() +
                             " is damaged: its SHA-256 is not the one " + "in " + manifest_file);
}

void require_no_state(const StateFolder& folder) {
  if (fs::exists(folder.store()) || fs::exists(folder.jobs()))
    throw std::runtime_error("the data directory " + folder.path().string() +
                             " has jobs; set another data_directory, or move them away");
}

}  // namespace

int restore(const StateFolder& folder, const fs::path& from, std::ostream& out) {
  const auto lines = read_manifest(from);
  make_state_folder(folder);
  {
    const StateLock lock(folder);
    require_no_state(folder);
    for (const ManifestLine& line : lines) copy_verified(line, from, folder.path());
    fs::create_directories(folder.jobs());
  }
  out << lines.size() << " files restored to " << folder.path().string() << std::endl;
  return check(folder, {.repair = true, .deep = false, .adopt = {}}, out);
}

}  // namespace dccast::state
