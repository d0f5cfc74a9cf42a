#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/job.pb.h"
#include "server/jobs/folder/job_description.hpp"

namespace dccast::jobs {

/// What a run had of its machine (server/worker/run_facts.hpp).
inline constexpr const char* run_facts_file = "run.json";

/// Subfolder for a job's attachments. It keeps them apart from the files of daemon and worker, so
/// that no attachment can replace one of those.
inline constexpr const char* attachments_folder = "attachments";

/// A file that a case names, as it lies in the data directory.
struct AttachedFile {
  std::string name;  ///< that the case gives it
  std::string sha256;
  std::int64_t bytes = 0;
  std::filesystem::path path{};        ///< synced to disk, and never written again
  std::shared_ptr<const void> hold{};  ///< keeps the file from being removed
};
using Attachments = std::vector<AttachedFile>;

/// Whether a name is permitted for an attachment: a single component of a path.
bool is_plain_file_name(const std::string& name);

/// The case file of the submitter, byte by byte.
inline constexpr const char* submitted_file = "case.toml";

/// Makes a folder of copies, under the names of their case. They are no links: a worker that a file
/// has taken over may write in its own folder, and must not reach the files of other jobs. They
/// survive a crash of the machine once the parent of `folder` is synced. @throws std::system_error
void add_attachments(const std::filesystem::path& folder, const Attachments& attachments);

/// The files that the case of a job names, in its folder; of one that is missing 0 bytes.
Attachments attachments_of(const std::filesystem::path& folder, const JobDescription& description);

/// Creates the folder of a job with its attachments and its description, synced to disk.
/// @param text  content of `submitted_file`; empty: no such file
/// @throws std::system_error  the folder cannot be written; nothing of it remains
void create_job_folder(const std::filesystem::path& folder, const Attachments& attachments,
                       const JobDescription& description, const std::string& text = {});

/// The file that mark_accepted() creates.
inline constexpr const char* accepted_file = "accepted";

/// Marks a folder, before its submission is answered: from then on its job survives a crash of the
/// machine. The folder is synced to disk. @throws std::system_error
void mark_accepted(const std::filesystem::path& folder);

/// A request of a caller that has not been carried out yet.
enum class RequestedAction { none, pause, cancel };

/// A request that the worker finds in its folder.
struct Request {
  RequestedAction action = RequestedAction::none;
  std::string reason;
};

/// Lock file of the daemon, beside `jobs/`. The daemon touches it every half second; workers read
/// from its time whether a daemon is running.
inline std::filesystem::path daemon_file(const std::filesystem::path& jobs_directory) {
  return jobs_directory.parent_path() / "lock";
}

// Names of files in the folder of a running job.
inline constexpr const char* withdrawn_file = "slurm.withdrawn";  ///< slurm_executor.cpp
inline constexpr const char* claim_file = "worker.lock";          ///< worker_claim.hpp
inline constexpr const char* order_file = "worker.order";         ///< the same
inline constexpr const char* rank_file = "worker.rank";           ///< the same
inline constexpr const char* request_file = "request";
inline constexpr const char* checkpoint_file = "checkpoint.bin";  ///< core/results/CHECKPOINT.md

/// The files that only a running job needs.
inline constexpr std::array run_files{checkpoint_file,
                                      "checkpoint.bin.tmp",
                                      "checkpoint.other-version.bin",
                                      "journal.bin",
                                      "results.h5.part",
                                      claim_file,
                                      order_file,
                                      rank_file,
                                      request_file,
                                      withdrawn_file};

/// Leaves a request in the folder of a running job, for its worker and for later daemons. The file
/// is synced to disk. @throws storage::StorageError  nothing has changed
void write_request(const std::filesystem::path& folder, const Request& request);
/// The pending request, if any. Costs one system call if there is none.
std::optional<Request> read_request(const std::filesystem::path& folder);
/// Removes the request that was carried out.
void remove_request(const std::filesystem::path& folder);

/// Stores what may change of a job after its submission: its labels, and whether it is pinned. The
/// file is synced to disk. @throws storage::StorageError  nothing has changed
void write_marks(const std::filesystem::path& folder, const v1::Job& job);
/// Applies the stored marks to a job as it was submitted. Missing marks change nothing; damaged
/// ones are logged and ignored.
void read_marks(const std::filesystem::path& folder, v1::Job& job);

/// Disk space of an ended job's folder, without the files that remove_run_files() removes [bytes].
/// Files that cannot be examined count as zero.
std::int64_t bytes_kept(const std::filesystem::path& folder);

/// Removes the files that only a running job needs: checkpoint, journal, unpublished results.
/// Results and logs stay. A failure is only logged, because such files do no harm.
void remove_run_files(const std::filesystem::path& folder);

/// Renames a checkpoint of another version, so that the run starts again from the beginning.
void set_checkpoint_aside(const std::filesystem::path& folder);

/// Temporary folder for the attachments of a case that is only checked. The destructor removes it.
class CheckFolder {
public:
  /// @param parent  directory in which the folder is created @throws std::system_error
  CheckFolder(const std::filesystem::path& parent, const Attachments& attachments);
  /// Removes the folder with its content.
  CheckFolder(const CheckFolder&) = delete;
  ~CheckFolder();
  const std::filesystem::path& path() const { return path_; }

private:
  std::filesystem::path path_;
};

}  // namespace dccast::jobs
