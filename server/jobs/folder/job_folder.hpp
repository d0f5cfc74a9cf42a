#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/job.pb.h"

namespace dccast::jobs {

/// The job as its folder describes it, so that its row in the store can be made again. Written
/// once, before the job is acknowledged.
struct JobDescription {
  v1::Job job;  ///< as it was submitted: identity, priority, owner, time, case_sha256
  std::string submitted_case;  ///< serialised
  std::string complete_case;   ///< serialised, with defaults and alloy card
  std::string answer_key{};    ///< see JobRecord; empty: none, or of an earlier version
  std::map<std::string, std::string> attachment_sha256{};  ///< by name; of an earlier version none
};

/// What a run had of its machine (server/worker/run_facts.hpp).
inline constexpr const char* run_facts_file = "run.json";

/// Name of the file: 8 bytes "DCCASTJD", version 2 and zero as in EVENT_LOG.md, then twice the same
/// frames: the serialised Job, the submitted Case, the complete Case, the answer key, the digests
/// of the attachments as sha256sum(1) writes them, each behind one byte that is 1. Where the first
/// five are damaged the second five are read. Version 1 has three or four frames, once.
inline constexpr const char* description_file = "description.bin";

/// Writes the file so that its content survives a crash; its name does after sync_directory().
/// @throws std::system_error
void write_job_description(const std::filesystem::path& folder, const JobDescription& description);

/// @throws std::runtime_error  there is none, or it is damaged; the text is the reason
JobDescription read_job_description(const std::filesystem::path& folder);

/// The case that runs. @return false where it cannot be read
bool read_complete_case(const std::filesystem::path& folder, v1::Case& to);

/// Where a job's attachments lie inside its folder: apart from what daemon and worker write there,
/// so that no attachment can take the name of one of those.
inline constexpr const char* attachments_folder = "attachments";

using Attachments = google::protobuf::RepeatedPtrField<v1::Attachment>;

/// Whether an attachment may have this name: one plain component of a path.
bool is_plain_file_name(const std::string& name);

/// The case as its submitter wrote it, byte by byte.
inline constexpr const char* submitted_file = "case.toml";

/// Makes the folder of a job with its attachments and its description; all of it survives a crash
/// of the machine once this has returned. @throws std::system_error; what was written is removed
/// again
/// @param text  for `submitted_file`; empty: there is none
void create_job_folder(const std::filesystem::path& folder, const Attachments& attachments,
                       const JobDescription& description, const std::string& text = {});

/// The mark of mark_accepted().
inline constexpr const char* accepted_file = "accepted";

/// Marks a folder whose job is in the store, before its submission is answered. A folder with the
/// mark and without a row means that rows were lost. A failure is logged: the job is kept without
/// it.
void mark_accepted(const std::filesystem::path& folder);

/// What a caller requested of a job and has not been carried out yet.
enum class RequestedAction { none, pause, cancel };

struct Request {
  RequestedAction action = RequestedAction::none;
  std::string reason;
};

/// The file beside `jobs/` that a daemon holds, and touches every half second: by its time workers
/// see that one is there.
inline std::filesystem::path daemon_file(const std::filesystem::path& jobs_directory) {
  return jobs_directory.parent_path() / "lock";
}

// Names of files in the folder of a job that is run.
inline constexpr const char* claim_file = "worker.lock";   ///< worker_claim.hpp
inline constexpr const char* order_file = "worker.order";  ///< the same
inline constexpr const char* rank_file = "worker.rank";    ///< the same

/// Leaves a request in the folder of a running job, for its worker and for any daemon that follows.
/// It survives a crash of the machine. @throws storage::StorageError  nothing has changed
void write_request(const std::filesystem::path& folder, const Request& request);
/// Costs a system call where there is none.
std::optional<Request> read_request(const std::filesystem::path& folder);
void remove_request(const std::filesystem::path& folder);

/// What may change of a job after its submission: labels, and whether it is kept for good. Survives
/// a crash of the machine. @throws storage::StorageError  nothing has changed
void write_marks(const std::filesystem::path& folder, const v1::Job& job);
/// Sets them in a job as it was submitted. Nothing is set where there are none, or they are
/// damaged, which is logged.
void read_marks(const std::filesystem::path& folder, v1::Job& job);

/// What the folder of an ended job holds on the disk, without what remove_run_files() removes
/// [bytes]; what cannot be looked at counts nothing.
std::int64_t bytes_kept(const std::filesystem::path& folder);

/// Removes what only a run that goes on needs: checkpoint, journal, unpublished results. Its
/// results and logs stay. A failure is logged: such files do no harm.
void remove_run_files(const std::filesystem::path& folder);

/// Takes a checkpoint of another version out of the way, so that the run starts over.
void set_checkpoint_aside(const std::filesystem::path& folder);

/// A folder for the attachments of a case that is only checked; removed with this object.
class CheckFolder {
public:
  /// @param parent  where the folder is made @throws std::system_error
  CheckFolder(const std::filesystem::path& parent, const Attachments& attachments);
  CheckFolder(const CheckFolder&) = delete;
  ~CheckFolder();
  const std::filesystem::path& path() const { return path_; }

private:
  std::filesystem::path path_;
};

}  // namespace dccast::jobs
