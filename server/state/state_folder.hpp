#pragma once

#include <filesystem>
#include <ostream>
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
  /// Of files that users have uploaded for cases that are still to come.
  std::filesystem::path uploads() const { return path_ / "uploads"; }
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

/// Copies a state folder, while its daemon works or not, to a new or empty directory.
///
/// The store comes first, in one instant; then the folders of the jobs that are in it. So every job
/// that was acknowledged before has its row and its folder, and a folder is never older than its
/// row: that is how a daemon finds them after a crash, and `check` lets rows follow the event logs.
/// Within a folder the checkpoint comes before the journal and the event log it counts on, and
/// results come last, as a terminal event is written when they have their final names.
/// @throws std::runtime_error  `to` is not empty, the store is damaged, or a file cannot be copied
void back_up(const StateFolder& folder, const std::filesystem::path& to, std::ostream& out);

/// Makes a state folder from a backup and checks it. @return damages that are left, as check()
/// @throws std::runtime_error  the folder is not empty, or the backup is not complete or damaged
int restore(const StateFolder& folder, const std::filesystem::path& from, std::ostream& out);

}  // namespace dccast::state
