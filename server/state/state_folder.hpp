#pragma once

#include <filesystem>
#include <stdexcept>

#include "core/storage/file.hpp"

namespace dccast::state {

/// Where things lie in a data directory. Knows names only; touches nothing.
class StateFolder {
public:
  explicit StateFolder(const std::filesystem::path& path)
      : path_(std::filesystem::absolute(path)) {}

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path jobs() const { return path_ / "jobs"; }
  std::filesystem::path studies() const { return path_ / "studies"; }
  std::filesystem::path check() const { return path_ / "check"; }  ///< of cases being checked
  std::filesystem::path store() const { return path_ / "jobs.sqlite"; }
  std::filesystem::path wal() const { return path_ / "jobs.sqlite-wal"; }
  std::filesystem::path shared_memory() const { return path_ / "jobs.sqlite-shm"; }
  std::filesystem::path quarantine() const { return path_ / "quarantine"; }
  std::filesystem::path lock() const { return path_ / "lock"; }

private:
  std::filesystem::path path_;
};

/// Holds a data directory for one process, as long as this lives: two daemons on one would run
/// every job twice.
class StateLock {
public:
  /// @throws std::runtime_error  another process has it
  explicit StateLock(const StateFolder& folder);

private:
  storage::File lock_;
};

/// Makes the data directory, the owner's alone. @throws std::filesystem::filesystem_error
void make_state_folder(const StateFolder& folder);

/// What to do about a state folder that has lost something, as the end of a sentence.
std::string repair_remedy(const StateFolder& folder);

}  // namespace dccast::state
