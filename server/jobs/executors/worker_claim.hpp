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

// Orders for workers on other machines, and the claim that keeps two workers from writing to one
// folder. A lock of the system may not hold between machines. The starts of a job are therefore
// ranked, and if two workers meet in a folder the one with the lower rank ends.

/// Writes the order for attempt `order.attempt()` into the folder of its job, for the worker that
/// will be started there. It replaces the order of an earlier attempt.
/// @throws storage::StorageError
void write_order(const v1::SolveCase& order);
/// @return nothing if there is no readable order
std::optional<v1::SolveCase> read_order(const std::filesystem::path& folder);

/// Rank of a worker among all starts of its job; a later start ranks higher.
struct StartRank {
  int attempt = 0;  ///< counted by the daemon
  int restart = 0;  ///< restarts of this attempt by Slurm
  auto operator<=>(const StartRank&) const = default;
};

/// Records a rank as the highest one of a folder, before the worker writes anything else there.
/// @return false: a higher one is recorded  @throws storage::StorageError
bool announce_rank(const std::filesystem::path& folder, const StartRank& rank);
/// Whether a later start of the job has announced itself.
bool is_superseded(const std::filesystem::path& folder, const StartRank& rank);
/// Whether a worker of this attempt, or of a later one, has announced itself. An attempt begins
/// only once; after the loss of its worker the next attempt begins, so that the log shows the loss.
bool has_begun(const std::filesystem::path& folder, int attempt);

/// Signs of a worker in its folder, on whatever machine it runs: two readings that differ are a
/// heartbeat. The files are opened to read them, which makes a network file system ask its server.
struct FolderSigns {
  std::int64_t claimed_ns = 0;  ///< time of the claim, which its worker touches [ns]
  std::int64_t log_bytes = 0;
  bool operator==(const FolderSigns&) const = default;
};
/// Signs of life in a folder; zero where there are none.
FolderSigns signs_in(const std::filesystem::path& folder);

/// Whether the folder holds the end of an attempt's run, and every result that it names.
bool shows_end_of_run(const std::filesystem::path& folder, int attempt);

/// Describes the first result that is missing, or whose size differs from that in the end of the
/// run; empty for none.
std::string missing_artifact(const std::filesystem::path& folder, const v1::RunEnd& end);

/// Version of the protocol between a running worker and the daemon: which of them appends to which
/// file of the folder, and the meaning of these files. A daemon adopts a worker of an earlier
/// program only if the versions are equal. Version 1 reported over a socket; version 2 wrote event
/// logs of version 1.
inline constexpr int worker_protocol = 3;

/// What a worker writes into its claim.
struct WorkerClaim {
  std::string job_id;
  int attempt = 0;
  int protocol = worker_protocol;
};

/// Another process has claimed the folder.
struct FolderTaken : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Claim of a worker on the folder of its job, held during the lifetime of this object. It keeps
/// two workers from writing to one folder, and lets the next daemon find the worker.
///
/// The claim is a lock of the operating system (fcntl) on `worker.lock`. It ends with its process,
/// and the system itself names that process, so that a reused process id is not mistaken for it.
/// The process must not open the file again, because closing it releases the lock.
class FolderClaim {
public:
  /// @param longest  time to wait for a worker that is about to end
  /// @param rank     of a worker on another machine than its daemon; announced before waiting for
  ///                 the lock, so that the worker of an earlier start releases it
  /// @throws FolderTaken           another worker has the folder
  /// @throws storage::StorageError  the file cannot be written
  FolderClaim(const std::filesystem::path& folder, const WorkerClaim& claim,
              std::chrono::milliseconds longest, std::optional<StartRank> rank = {});
  /// Why the claim is lost: the folder was removed, moved or restored from a backup, or a later
  /// start has claimed it. Empty: it still holds.
  std::string loss() const;
  /// Heartbeat: sets the time of the file to now.
  void touch() const;

private:
  std::optional<StartRank> rank_;
  storage::File lock_;
};

/// A process that claims a folder.
struct ClaimHolder {
  pid_t process = 0;
  storage::FileDescriptor handle;  ///< pidfd; it is certain to be this process
  /// Nothing: the claim was not written yet, or cannot be parsed.
  std::optional<WorkerClaim> claim{};
};

/// Finds the process that claims a folder. The holder itself must not call this, see FolderClaim.
/// @return nothing if no process does  @throws std::system_error  it cannot be determined
std::optional<ClaimHolder> find_holder(const std::filesystem::path& folder);

// Exit codes with which a worker names the resource that it lacked.
inline constexpr int exit_out_of_memory = 71;
inline constexpr int exit_storage = 74;
inline constexpr int exit_begun_before = 75;  ///< lacks nothing: the attempt has begun before

inline constexpr const char* out_of_memory_text =
    "the worker could get no more memory: make the mesh coarser, run fewer workers at once, or "
    "give it more (ulimit -v, the limit of the container)";

}  // namespace dccast::jobs
