#pragma once

#include <compare>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

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
/// Exit code of a worker whose attempt has begun before.
inline constexpr int exit_begun_before = 75;

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

}  // namespace dccast::jobs
