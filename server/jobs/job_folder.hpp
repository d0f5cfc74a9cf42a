#pragma once

#include <filesystem>
#include <string>

#include "dccast/v1/job.pb.h"

namespace dccast::jobs {

/// Where a job's attachments lie inside its folder: apart from what daemon and worker write there,
/// so that no attachment can take the name of one of those.
inline constexpr const char* attachments_folder = "attachments";

using Attachments = google::protobuf::RepeatedPtrField<v1::Attachment>;

/// Whether an attachment may have this name: one plain component of a path.
bool is_plain_file_name(const std::string& name);

/// Makes the folder of a job with its attachments; all of it survives a crash of the machine once
/// this has returned. @throws std::system_error; what was written is removed again
void create_job_folder(const std::filesystem::path& folder, const Attachments& attachments);

/// Removes what only a run that goes on needs: checkpoint, journal, unpublished results. Its
/// results and logs stay. A failure is logged: such files do no harm.
void remove_run_files(const std::filesystem::path& folder);

/// Takes a checkpoint of another version out of the way, so that the run begins anew.
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
