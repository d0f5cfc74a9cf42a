#pragma once

#include <filesystem>
#include <ostream>
#include <stdexcept>

#include "core/storage/file_lock.hpp"

namespace dccast::state {

/// Paths inside a data directory. Only composes names; does not access the disk.
class StateFolder {
public:
  explicit StateFolder(const std::filesystem::path& path)
      : path_(std::filesystem::absolute(path)) {}

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path jobs() const { return path_ / "jobs"; }
  std::filesystem::path studies() const { return path_ / "studies"; }
  std::filesystem::path lines() const { return path_ / "lines"; }
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

/// Locks a data directory for this process: two daemons on one directory would run every job twice.
class StateLock {
public:
  /// @throws std::runtime_error  another process has it
  explicit StateLock(const StateFolder& folder);

private:
  storage::FileLock lock_;
};

/// Checks that all jobs, studies and lines have the format of this program.
/// @throws jobs::OtherFormat  the text names the first that has not, and the remedy
/// @throws std::system_error
void require_data_format(const StateFolder& folder);

/// Moves what stands in place of the folders of studies, lines and uploads, and is no folder, to
/// NAME.aside, with a line in the log. @throws std::system_error
void set_strange_folders_aside(const StateFolder& folder);

/// Creates the data directory, accessible to its owner only. @throws
/// std::filesystem::filesystem_error
void make_state_folder(const StateFolder& folder);

/// Copies a state folder to a new or empty directory; its daemon may be running.
///
/// The store is copied first, as one snapshot, then the folders of the jobs in it. Every job that
/// was acknowledged before has a row and a folder, and no folder is older than its row. A daemon
/// finds the same after a crash, and `check` updates rows from the event logs. Within a folder the
/// checkpoint is copied before the journal and the event log on which it depends, and results are
/// copied last, because the terminal event is written after they have their final names.
/// @param earlier  a backup on the same file system, or empty: files that it has with the same
///                 content become hard links to them
/// @throws std::runtime_error  `to` is not empty, the store is damaged, a file cannot be copied, or
///                             `earlier` is no complete backup
void back_up(const StateFolder& folder, const std::filesystem::path& to,
             const std::filesystem::path& earlier, std::ostream& out);

/// Restores a state folder from a backup and checks it. @return damages that remain, as check()
/// @throws std::runtime_error  the folder is not empty, or the backup is not complete or damaged
int restore(const StateFolder& folder, const std::filesystem::path& from, std::ostream& out);

}  // namespace dccast::state
