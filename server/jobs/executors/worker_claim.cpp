#include "server/jobs/executors/worker_claim.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <sstream>
#include <system_error>
#include <thread>

#include "core/storage/file.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "server/jobs/logs/event_log_scan.hpp"
#include "server/jobs/processes.hpp"

namespace dccast::jobs {

namespace {

std::optional<StartRank> highest_rank(const std::filesystem::path& folder) {
  try {
    std::istringstream text(storage::read_file(folder / rank_file));
    StartRank rank;
    text >> rank.attempt >> rank.restart;
    return text ? std::optional(rank) : std::nullopt;
  } catch (const std::system_error&) {
    return std::nullopt;
  }
}

/// Status of a file. Opening it makes a network file system ask its server for the present state.
/// @return nothing if the file does not exist or cannot be opened
std::optional<struct stat> status_of(const std::filesystem::path& path) {
  try {
    struct stat status {};
    const storage::File file(path, O_RDONLY);
    if (::fstat(file.descriptor(), &status) == 0) return status;
  } catch (const std::system_error&) {
    // Most likely the file does not exist.
  }
  return std::nullopt;
}

constexpr std::chrono::milliseconds between_tries{10};

/// A lock on a whole file, for fcntl().
struct flock whole_file() {
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  return lock;
}

bool try_lock(const storage::File& file) {
  struct flock lock = whole_file();
  if (::fcntl(file.descriptor(), F_SETLK, &lock) == 0) return true;
  if (errno == EACCES || errno == EAGAIN) return false;
  throw std::system_error(errno, std::generic_category(),
                          fmt::format("cannot lock {}", file.path().string()));
}

/// @return the process that has the lock; 0 for none
pid_t find_lock_owner(const storage::File& file) {
  struct flock lock = whole_file();
  if (::fcntl(file.descriptor(), F_GETLK, &lock) != 0)
    throw std::system_error(errno, std::generic_category(),
                            fmt::format("cannot inspect the lock on {}", file.path().string()));
  // A negative id is a process of another machine, which has no handle here.
  return lock.l_type == F_UNLCK ? 0 : std::max(lock.l_pid, 0);
}

/// @return nothing for an incomplete text
std::optional<WorkerClaim> parse_claim(const std::string& text) {
  if (!text.ends_with('\n')) return std::nullopt;
  std::istringstream words(text);
  WorkerClaim claim;
  words >> claim.protocol >> claim.attempt >> claim.job_id;
  return words ? std::optional(claim) : std::nullopt;
}

}  // namespace

void write_order(const v1::SolveCase& order) {
  storage::replace_file(std::filesystem::path(order.directory()) / order_file,
                        order.SerializeAsString());
}

std::optional<v1::SolveCase> read_order(const std::filesystem::path& folder) {
  try {
    v1::SolveCase order;
    const bool read = order.ParseFromString(storage::read_file(folder / order_file));
    return read && order.attempt() > 0 ? std::optional(order) : std::nullopt;
  } catch (const std::system_error&) {
    return std::nullopt;
  }
}

bool announce_rank(const std::filesystem::path& folder, const StartRank& rank) {
  if (is_superseded(folder, rank)) return false;
  storage::replace_file(folder / rank_file, fmt::format("{} {}\n", rank.attempt, rank.restart));
  return true;
}

bool is_superseded(const std::filesystem::path& folder, const StartRank& rank) {
  const auto highest = highest_rank(folder);
  return highest && *highest > rank;
}

bool has_begun(const std::filesystem::path& folder, int attempt) {
  return is_superseded(folder, {.attempt = attempt, .restart = -1});
}

FolderSigns signs_in(const std::filesystem::path& folder) {
  FolderSigns signs;
  if (const auto claim = status_of(folder / claim_file))
    signs.claimed_ns = claim->st_mtim.tv_sec * 1'000'000'000 + claim->st_mtim.tv_nsec;
  if (const auto log = status_of(folder / "events.log")) signs.log_bytes = log->st_size;
  return signs;
}

bool shows_end_of_run(const std::filesystem::path& folder, int attempt) {
  try {
    const auto end = scan_event_log(folder / "events.log").run_end;
    return end && end->attempt() == attempt && missing_artifact(folder, *end).empty();
  } catch (const std::exception&) {
    return false;  // the file cannot be read now
  }
}

std::string missing_artifact(const std::filesystem::path& folder, const v1::RunEnd& end) {
  if (end.outcome() != v1::RunEnd::SUCCEEDED) return {};
  for (const v1::Artifact& artifact : end.artifacts()) {
    const auto status = status_of(folder / artifact.name());
    if (!status)
      return fmt::format("result {} is missing: {}", artifact.name(),
                         std::generic_category().message(errno));
    if (status->st_size != artifact.size_bytes())
      return fmt::format("result {} does not have the size that its worker wrote", artifact.name());
  }
  return {};
}

FolderClaim::FolderClaim(const std::filesystem::path& folder, const WorkerClaim& claim,
                         std::chrono::milliseconds longest, std::optional<StartRank> rank)
    : rank_(rank) {
  if (rank && !announce_rank(folder, *rank))
    throw FolderTaken(fmt::format("a later start of the job has claimed {}", folder.string()));

  lock_ = storage::File(folder / claim_file, O_RDWR | O_CREAT);
  const auto end = std::chrono::steady_clock::now() + longest;
  while (!try_lock(lock_)) {
    if (std::chrono::steady_clock::now() > end)
      throw FolderTaken(fmt::format("another worker (process {}) writes into {}",
                                    find_lock_owner(lock_), folder.string()));
    std::this_thread::sleep_for(between_tries);
  }

  lock_.cut(0);
  lock_.write_at(0, fmt::format("{} {} {}\n", claim.protocol, claim.attempt, claim.job_id));
}

std::string FolderClaim::loss() const {
  using Status = struct stat;
  Status held{};
  Status there{};
  if (::fstat(lock_.descriptor(), &held) != 0 || ::stat(lock_.path().c_str(), &there) != 0 ||
      held.st_dev != there.st_dev || held.st_ino != there.st_ino)
    return "the folder of the job is gone";

  if (rank_ && is_superseded(lock_.path().parent_path(), *rank_))
    return "a later start of the job has its folder";
  return {};
}

void FolderClaim::touch() const {
  ::futimens(lock_.descriptor(), nullptr);
}

std::optional<ClaimHolder> find_holder(const std::filesystem::path& folder) {
  const auto path = folder / claim_file;
  if (!std::filesystem::exists(path)) return std::nullopt;

  const storage::File file(path, O_RDWR);
  const pid_t process = find_lock_owner(file);
  if (process == 0) return std::nullopt;

  ClaimHolder holder{.process = process, .handle = open_process(process)};
  const int error = errno;

  // If it still has the lock, its id was not given to another process before open_process().
  if (find_lock_owner(file) != process) return std::nullopt;

  if (!holder.handle)
    throw std::system_error(error, std::generic_category(),
                            fmt::format("cannot open a handle of worker process {}", process));

  holder.claim = parse_claim(storage::read_file(path));
  return holder;
}

}  // namespace dccast::jobs
