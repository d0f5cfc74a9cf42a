#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>

#include "core/storage/file.hpp"
#include "server/jobs/worker_order.hpp"

namespace dccast::jobs {

/// Version of what a worker and a daemon agree on while the worker runs: who appends to which file
/// of the folder, and what means what. A daemon leads on a worker of an earlier program only when
/// this is equal. Version 1 reported over a socket.
inline constexpr int worker_protocol = 2;

/// What a worker writes of itself in the folder of its job.
struct WorkerClaim {
  std::string job_id;
  int attempt = 0;
  int protocol = worker_protocol;
};

/// Another process works in the folder.
class FolderTaken : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// The folder of a job, claimed by the worker that writes into it, as long as this lives: no two
/// workers write one folder, whatever the daemons do, and the next daemon finds the one that does.
///
/// The claim is a lock of the operating system (fcntl) on `worker.lock`, so that it ends with its
/// process, and the system itself names that process: an id that was given to another process,
/// for example after a restart of the machine, is not mistaken for it. The process must not open
/// the file again: closing it gives up the lock.
class FolderClaim {
public:
  /// @param longest  to wait for a worker that is about to end
  /// @param rank     of a worker on another machine than its daemon; announced before the lock is
  ///                 waited for, so that the worker of an earlier start gives it up
  /// @throws FolderTaken           another worker has the folder
  /// @throws storage::StorageError  the file cannot be written
  FolderClaim(const std::filesystem::path& folder, const WorkerClaim& claim,
              std::chrono::milliseconds longest, std::optional<StartRank> rank = {});
  /// Why the folder is no longer this worker's: it was removed, moved or put back from a backup, or
  /// a later start has it. Empty: it is.
  std::string loss() const;
  /// A sign of life: sets the time of the file to now.
  void touch() const;

private:
  std::optional<StartRank> rank_;
  storage::File lock_;
};

/// A process that claims a folder.
struct ClaimHolder {
  pid_t process = 0;
  storage::FileDescriptor handle;  ///< pidfd, of this process beyond doubt
  /// Nothing: it has not written who it is, or cannot be understood.
  std::optional<WorkerClaim> claim{};
};

/// Who claims a folder. Not for the holder itself, see FolderClaim. @return nothing if no one does
/// @throws std::system_error  it cannot be found out
std::optional<ClaimHolder> holder_of(const std::filesystem::path& folder);

// Exit codes by which a worker names the resource that kept it from ending its run in good order.
inline constexpr int exit_out_of_memory = 71;
inline constexpr int exit_storage = 74;

inline constexpr const char* out_of_memory_text =
    "the worker could get no more memory: make the mesh coarser, run fewer workers at once, or "
    "give it more (ulimit -v, the limit of the container)";

}  // namespace dccast::jobs
