#pragma once

#include <sys/types.h>

#include <chrono>
#include <compare>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>

#include "core/storage/file.hpp"
#include "dccast/v1/worker.pb.h"

namespace dccast::jobs {

// How a worker on another machine is given its job, and how two of them never write one folder. A
// lock of the system may not hold between machines, so the starts of a job have an order, and of
// two workers that meet in a folder the one of the earlier start ends.

/// Leaves the order for attempt `order.attempt()` in the folder of its job, for the worker that
/// will be started there; one for an earlier attempt is void then. @throws storage::StorageError
void write_order(const v1::SolveCase& order);
/// @return nothing where there is none that can be read
std::optional<v1::SolveCase> read_order(const std::filesystem::path& folder);

/// Place of a worker among all starts of its job: the later one ranks higher.
struct StartRank {
  int attempt = 0;  ///< of the daemon
  int restart = 0;  ///< of this attempt by Slurm
  auto operator<=>(const StartRank&) const = default;
};

/// Makes a rank the highest one of a folder, before the worker touches anything in it.
/// @return false: a higher one was there  @throws storage::StorageError
bool announce_rank(const std::filesystem::path& folder, const StartRank& rank);
/// Whether a later start of the job has announced itself.
bool is_superseded(const std::filesystem::path& folder, const StartRank& rank);
/// Whether a worker of this attempt, or of a later one, has announced itself. An attempt begins
/// once: what follows the loss of its worker is the next one, so that the log says where.
bool has_begun(const std::filesystem::path& folder, int attempt);

/// What a folder shows of a worker in it, wherever that runs: two looks that differ are a sign of
/// life. Files are opened for it, which makes a network file system ask its server.
struct FolderSigns {
  std::int64_t claimed_ns = 0;  ///< time of the claim, which its worker touches
  std::int64_t log_bytes = 0;
  bool operator==(const FolderSigns&) const = default;
};
FolderSigns signs_in(const std::filesystem::path& folder);

/// Whether the folder shows the end of the run of an attempt, and every result that it names.
bool shows_end_of_run(const std::filesystem::path& folder, int attempt);

/// A result that is not there as the end of a run names it; empty for none.
std::string missing_artifact(const std::filesystem::path& folder, const v1::RunEnd& end);

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
struct FolderTaken : std::runtime_error {
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
inline constexpr int exit_begun_before = 75;  ///< no resource: the attempt has begun before

inline constexpr const char* out_of_memory_text =
    "the worker could get no more memory: make the mesh coarser, run fewer workers at once, or "
    "give it more (ulimit -v, the limit of the container)";

}  // namespace dccast::jobs
