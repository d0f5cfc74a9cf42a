#include "server/jobs/folder/job_folder.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "core/storage/file.hpp"
#include "proto/values/digests.hpp"
#include "server/jobs/folder/format.hpp"
#include "server/jobs/log.hpp"

namespace dccast::jobs {

namespace {

constexpr const char* marks_file = "marks";

void remove_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::remove_all(folder, error);
  if (error) log::warn("cannot remove {}: {}", folder.string(), error.message());
}

void remove_file(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::remove(path, error);
  if (error) log::warn("cannot remove {}: {}", path.string(), error.message());
}

/// Reads an optional file. @return nothing if there is none, or if the entry is no regular file
std::optional<std::string> read_if_present(const std::filesystem::path& path) {
  const std::string kind = storage::kind_of_entry(path);
  if (kind.empty()) return std::nullopt;
  if (kind == storage::regular_file) return storage::read_file(path);

  // Opening a named pipe would block; a directory cannot be read.
  log::warn("{} is {}, not {}: it is ignored", path.string(), kind, storage::regular_file);
  return std::nullopt;
}

void make_directory(const std::filesystem::path& path) {
  if (::mkdir(path.c_str(), 0700) != 0)
    throw std::system_error(errno, std::generic_category(),
                            fmt::format("cannot make {}", path.string()));
}

void copy_attachments(const std::filesystem::path& folder, const Attachments& attachments) {
  make_directory(folder);
  for (const AttachedFile& attachment : attachments)
    std::filesystem::copy_file(attachment.path, folder / attachment.name);
}

}  // namespace

void add_attachments(const std::filesystem::path& folder, const Attachments& attachments) {
  copy_attachments(folder, attachments);
  for (const AttachedFile& attachment : attachments)
    storage::File(folder / attachment.name, O_RDWR).sync();
  if (!attachments.empty()) storage::sync_directory(folder);
}

Attachments attachments_of(const std::filesystem::path& folder, const JobDescription& description) {
  Attachments files;
  for (const auto& [name, sha256] : description.attachment_sha256) {
    const auto path = folder / attachments_folder / name;
    std::error_code missing;
    const auto size = std::filesystem::file_size(path, missing);
    files.push_back({.name = name,
                     .sha256 = sha256,
                     .bytes = missing ? 0 : static_cast<std::int64_t>(size),
                     .path = path});
  }
  return files;
}

bool is_plain_file_name(const std::string& name) {
  return !name.empty() && name.size() <= 255 && name != "." && name != ".." &&
         name.find('/') == std::string::npos && name.find('\0') == std::string::npos;
}

void create_job_folder(const std::filesystem::path& folder, const Attachments& attachments,
                       const JobDescription& description, const std::string& text) {
  try {
    make_directory(folder);
    add_attachments(folder / attachments_folder, attachments);

    JobDescription with_digests = description;
    for (const AttachedFile& attachment : attachments)
      with_digests.attachment_sha256[attachment.name] = attachment.sha256;
    write_job_description(folder, with_digests);
    if (!text.empty()) storage::create_durably(folder / submitted_file, text);

    storage::sync_directory(folder);
    storage::sync_directory(folder.parent_path());
  } catch (...) {
    remove_folder(folder);
    throw;
  }
}

void write_request(const std::filesystem::path& folder, const Request& request) {
  const char* action = request.action == RequestedAction::cancel ? "cancel" : "pause";
  storage::replace_file(folder / request_file, fmt::format("{}\n{}", action, request.reason));
}

std::optional<Request> read_request(const std::filesystem::path& folder) {
  const auto text = read_if_present(folder / request_file);
  if (!text) return std::nullopt;

  const std::size_t line = std::min(text->find('\n'), text->size());
  const auto action =
      text->substr(0, line) == "pause" ? RequestedAction::pause : RequestedAction::cancel;
  return Request{action, text->substr(std::min(line + 1, text->size()))};
}

void remove_request(const std::filesystem::path& folder) {
  remove_file(folder / request_file);
}

void write_marks(const std::filesystem::path& folder, const v1::Job& job) {
  v1::Job marks;
  *marks.mutable_labels() = job.labels();
  marks.set_pinned(job.pinned());
  marks.set_priority(job.priority());
  storage::replace_file(folder / marks_file, framed_part(marks.SerializeAsString()));
}

void read_marks(const std::filesystem::path& folder, v1::Job& job) {
  const std::filesystem::path path = folder / marks_file;
  const auto bytes = read_if_present(path);
  if (!bytes) return;

  v1::Job marks;
  const auto part = first_part(*bytes);
  if (!part || !marks.ParseFromString(std::string(part->content)))
    return log::warn("{} is damaged: the job keeps labels and priority of its submission",
                     path.string());

  *job.mutable_labels() = marks.labels();
  job.set_pinned(marks.pinned());
  if (marks.priority() != v1::PRIORITY_UNSPECIFIED) job.set_priority(marks.priority());
}

std::int64_t bytes_kept(const std::filesystem::path& folder) {
  std::int64_t bytes = 0;
  std::error_code error;
  for (std::filesystem::recursive_directory_iterator file(folder, error), end;
       !error && file != end; file.increment(error)) {
    std::error_code gone;  // a file may be removed during the walk
    const bool counts = file->is_regular_file(gone) &&
                        std::ranges::find(run_files, file->path().filename()) == run_files.end();
    const auto size = counts ? file->file_size(gone) : 0;
    if (!gone) bytes += static_cast<std::int64_t>(size);
  }
  return bytes;
}

void remove_run_files(const std::filesystem::path& folder) {
  for (const char* name : run_files) remove_file(folder / name);
}

void set_checkpoint_aside(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::rename(folder / checkpoint_file, folder / "checkpoint.other-version.bin", error);
  if (error) log::warn("{}: cannot set the checkpoint aside: {}", folder.string(), error.message());
}

void mark_accepted(const std::filesystem::path& folder) {
  { const storage::File mark(folder / accepted_file, O_WRONLY | O_CREAT); }
  storage::sync_directory(folder);
}

CheckFolder::CheckFolder(const std::filesystem::path& parent, const Attachments& attachments)
    : path_(parent / values::random_uuid()) {
  try {
    make_directory(path_);
    copy_attachments(path_ / attachments_folder, attachments);
  } catch (...) {
    remove_folder(path_);
    throw;
  }
}

CheckFolder::~CheckFolder() {
  remove_folder(path_);
}

}  // namespace dccast::jobs
