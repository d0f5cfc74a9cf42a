#include "server/jobs/job_folder.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "core/storage/file.hpp"
#include "proto/values/digests.hpp"
#include "server/jobs/event_log_scan.hpp"
#include "server/jobs/log.hpp"

namespace dccast::jobs {

namespace {

constexpr const char* checkpoint_name = "checkpoint.bin";  // core/results/CHECKPOINT.md
constexpr const char* accepted_file = "accepted";
constexpr const char* request_file = "request";

void remove_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::remove_all(folder, error);
  if (error) spdlog::warn("cannot remove {}: {}", folder.string(), error.message());
}

void make_directory(const std::filesystem::path& path) {
  if (::mkdir(path.c_str(), 0700) != 0)
    throw std::system_error(errno, std::generic_category(), "cannot make " + path.string());
}

void write_attachments(const std::filesystem::path& folder, const Attachments& attachments) {
  make_directory(folder);
  make_directory(folder / attachments_folder);
  for (const v1::Attachment& attachment : attachments)
    storage::create_durably(folder / attachments_folder / attachment.name(), attachment.content());
}

}  // namespace

bool is_plain_file_name(const std::string& name) {
  return !name.empty() && name.size() <= 255 && name != "." && name != ".." &&
         name.find('/') == std::string::npos && name.find('\0') == std::string::npos;
}

void create_job_folder(const std::filesystem::path& folder, const Attachments& attachments,
                       const JobDescription& description) {
  try {
    write_attachments(folder, attachments);
    write_job_description(folder, description);
    if (!attachments.empty()) storage::sync_directory(folder / attachments_folder);
    storage::sync_directory(folder);
    storage::sync_directory(folder.parent_path());
  } catch (...) {
    remove_folder(folder);
    throw;
  }
}

void write_request(const std::filesystem::path& folder, const Request& request) {
  const char* action = request.action == RequestedAction::cancel ? "cancel" : "pause";
  storage::replace_file(folder / request_file, std::string(action) + "\n" + request.reason);
}

std::optional<Request> read_request(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / request_file;
  if (::access(path.c_str(), F_OK) != 0) return std::nullopt;
  const std::string text = storage::read_file(path);
  const std::size_t line = std::min(text.find('\n'), text.size());
  const auto action =
      text.substr(0, line) == "pause" ? RequestedAction::pause : RequestedAction::cancel;
  return Request{action, text.substr(std::min(line + 1, text.size()))};
}

void remove_request(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::remove(folder / request_file, error);
  if (error) spdlog::warn("cannot remove {}: {}", (folder / request_file).string(), error.message());
}

void remove_run_files(const std::filesystem::path& folder) {
  for (const char* name : {checkpoint_name, "checkpoint.bin.tmp", "checkpoint.other-version.bin",
                           "journal.bin", "results.h5.part", "worker.lock", request_file}) {
    std::error_code error;
    std::filesystem::remove(folder / name, error);
    if (error) spdlog::warn("cannot remove {}: {}", (folder / name).string(), error.message());
  }
}

void set_checkpoint_aside(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::rename(folder / checkpoint_name, folder / "checkpoint.other-version.bin", error);
  if (error)
    spdlog::warn("{}: cannot set the checkpoint aside: {}", folder.string(), error.message());
}

void mark_accepted(const std::filesystem::path& folder) {
  try {
    storage::File(folder / accepted_file, O_WRONLY | O_CREAT);
  } catch (const std::system_error& error) {
    spdlog::warn("{}", error.what());
  }
}

bool was_accepted(const std::filesystem::path& folder) {
  if (std::filesystem::exists(folder / accepted_file)) return true;
  const auto log = folder / "events.log";
  return std::filesystem::exists(log) && scan_event_log(log).last_sequence > 1;
}

CheckFolder::CheckFolder(const std::filesystem::path& parent, const Attachments& attachments)
    : path_(parent / values::random_uuid()) {
  try {
    write_attachments(path_, attachments);
  } catch (...) {
    remove_folder(path_);
    throw;
  }
}

CheckFolder::~CheckFolder() {
  remove_folder(path_);
}

}  // namespace dccast::jobs
