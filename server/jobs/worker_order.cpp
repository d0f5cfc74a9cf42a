#include "server/jobs/worker_order.hpp"

#include <fcntl.h>
#include <sys/stat.h>

#include <sstream>
#include <system_error>

#include "core/storage/file.hpp"
#include "server/jobs/event_log_scan.hpp"
#include "server/jobs/job_folder.hpp"

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

/// Of the file as its server has it now; nothing where it cannot be opened.
std::optional<struct stat> status_of(const std::filesystem::path& path) {
  struct stat status {};
  const storage::FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file || ::fstat(file.get(), &status) != 0) return std::nullopt;
  return status;
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
  storage::replace_file(folder / rank_file,
                        std::to_string(rank.attempt) + " " + std::to_string(rank.restart) + "\n");
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
    return false;  // a file that cannot be read now
  }
}

std::string missing_artifact(const std::filesystem::path& folder, const v1::RunEnd& end) {
  if (end.outcome() != v1::RunEnd::SUCCEEDED) return {};
  for (const v1::Artifact& artifact : end.artifacts()) {
    const auto status = status_of(folder / artifact.name());
    if (!status)
      return "result " + artifact.name() +
             " is not there: " + std::generic_category().message(errno);
    if (status->st_size != artifact.size_bytes())
      return "result " + artifact.name() + " has not the size its worker wrote";
  }
  return {};
}

}  // namespace dccast::jobs
