#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "dccast/v1/job.pb.h"
#include "server/jobs/job_description.hpp"

namespace dccast::jobs {

/// Where a job's attachments lie inside its folder: apart from what daemon and worker write there,
/// so that no attachment can take the name of one of those.
inline constexpr const char* attachments_folder = "attachments";

using Attachments = google::protobuf::RepeatedPtrField<v1::Attachment>;

/// Whether an attachment may have this name: one plain component of a path.
bool is_plain_file_name(const std::string& name);

/// Makes the folder of a job with its attachments and its description; all of it survives a crash
/// of the machine once this has returned. @throws std::system_error; what was written is removed
/// again
void create_job_folder(const std::filesystem::path& folder, const Attachments& attachments,
                       const JobDescription& description);

/// Marks a folder whose job is in the store, before who submitted it hears so. A folder with the
/// mark and without a row says that rows were lost. A failure is logged: the job is kept without
/// it.
void mark_accepted(const std::filesystem::path& folder);

/// Whether a folder belongs to a job that was acknowledged: it has the mark, or its event log says
/// more than that the job was submitted. @throws std::system_error
bool was_accepted(const std::filesystem::path& folder);

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

/// Leaves a request in the folder of a running job, for its worker and for any daemon that follows.
/// It survives a crash of the machine. @throws storage::StorageError  nothing has changed
void write_request(const std::filesystem::path& folder, const Request& request);
/// Costs a system call where there is none.
std::optional<Request> read_request(const std::filesystem::path& folder);
void remove_request(const std::filesystem::path& folder);

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
