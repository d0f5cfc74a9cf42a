#include "server/intake/uploads.hpp"

#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <condition_variable>
#include <numeric>
#include <system_error>

#include "core/storage/storage_error.hpp"
#include "proto/values/printable.hpp"
#include "server/intake/case_intake.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/queue/queue_hold.hpp"

namespace dccast::intake {

namespace {

using storage::megabytes;

std::string shown_name(const v1::Attachment& attachment) {
  return values::shown(attachment.name());
}

/// @param limit      key of the setting
/// @param permitted  its value
UploadRefused refuse(const v1::Attachment& announced, const std::string& limit,
                     const std::string& permitted, const std::string& message,
                     const std::string& remedy) {
  const std::string given =
      fmt::format("{} of {}", shown_name(announced), megabytes(announced.size_bytes()));
  return {
      {.cause = fmt::format("{} {}", given, message),
       .limit = limit,
       .permitted = permitted,
       .remedy = remedy},
      fault_of("attachments", given, message, fmt::format("{} = {}", limit, permitted), remedy)};
}

}  // namespace

UploadRefused::UploadRefused(refusal::Facts facts, v1::Fault fault)
    : LimitReached(std::move(facts)), fault_(std::move(fault)) {}

void Uploads::Held::change(const std::string& user, std::int64_t bytes) {
  const std::lock_guard lock(mutex_);
  all_ += bytes;
  const auto found = of_user_.try_emplace(user).first;
  found->second += bytes;
  if (found->second == 0) of_user_.erase(found);
}

std::int64_t Uploads::Held::of(const std::string& user) const {
  const std::lock_guard lock(mutex_);
  const auto found = of_user_.find(user);
  return found == of_user_.end() ? 0 : found->second;
}

std::int64_t Uploads::Held::all() const {
  const std::lock_guard lock(mutex_);
  return all_;
}

Uploads::StagedFile::StagedFile(std::shared_ptr<Held> held, std::string user, std::int64_t bytes,
                                std::filesystem::path path)
    : held_(std::move(held)), user_(std::move(user)), bytes_(bytes), path_(std::move(path)) {
  held_->change(user_, bytes_);
}

Uploads::StagedFile::~StagedFile() {
  std::error_code error;
  std::filesystem::remove(path_, error);
  if (error) log::warn("cannot remove {}: {}", path_.string(), error.message());
  held_->change(user_, -bytes_);
}

Uploads::Uploads(std::filesystem::path directory, const Limits& limits)
    : directory_(std::move(directory)), limits_(limits) {
  std::filesystem::remove_all(directory_);
  std::filesystem::create_directories(directory_);
  watcher_ = std::jthread([this](const std::stop_token& stop) { watch_for_expiry(stop); });
}

std::optional<jobs::AttachedFile> Uploads::find(const std::string& user,
                                                const v1::Attachment& named) {
  const std::lock_guard lock(mutex_);
  const auto found = files_.find({user, named.sha256()});
  if (found == files_.end()) return std::nullopt;

  Entry& entry = found->second;
  entry.last_used = Clock::now();
  entry.was_used = true;
  return jobs::AttachedFile{.name = named.name(),
                            .sha256 = named.sha256(),
                            .bytes = entry.file->bytes(),
                            .path = entry.file->path(),
                            .hold = entry.file};
}

bool Uploads::renew(const std::string& user, const v1::Attachment& announced) {
  const std::lock_guard lock(mutex_);
  const auto found = files_.find({user, announced.sha256()});
  if (found == files_.end()) return false;

  found->second.last_used = Clock::now();
  found->second.was_used = false;  // protects the file from make_room() until it is used
  return true;
}

std::unique_ptr<Uploads::Upload> Uploads::begin(const std::string& user,
                                                const v1::Attachment& announced) {
  if (announced.size_bytes() > limits_.largest)
    throw refuse(
        announced, "per_case.maximum_attachment", megabytes(limits_.largest),
        "is larger than a file of a case may be",
        "make the mesh coarser, or have per_case.maximum_attachment raised in the settings "
        "of dccastd");
  jobs::require_free_space(directory_, limits_.minimum_free + announced.size_bytes());

  const std::lock_guard lock(mutex_);
  count_upload(user);
  try {
    make_room(user, announced);
    const auto file = std::make_shared<StagedFile>(held_, user, announced.size_bytes(),
                                                   directory_ / values::random_uuid());
    return std::make_unique<Upload>(*this, user, announced, file);
  } catch (...) {
    --under_way_[user];
    throw;
  }
}

/// Counts an upload against the limits, because each holds a chunk in memory.
void Uploads::count_upload(const std::string& user) {
  const int of_all = std::accumulate(under_way_.begin(), under_way_.end(), 0,
                                     [](int sum, const auto& entry) { return sum + entry.second; });

  int& of_user = under_way_[user];
  if (of_user >= limits_.at_once_of_user || of_all >= limits_.at_once)
    throw TooManyUploads(
        fmt::format("{} uploads of {} and {} in all are under way; at most {} and {} are taken at "
                    "once",
                    of_user, user, of_all, limits_.at_once_of_user, limits_.at_once));
  ++of_user;
}

void Uploads::end_upload(const std::string& user) {
  const std::lock_guard lock(mutex_);
  const auto found = under_way_.find(user);
  if (--found->second == 0) under_way_.erase(found);
}

/// Removes used files to make room: their jobs have copies.
void Uploads::make_room(const std::string& user, const v1::Attachment& announced) {
  const std::string remedy =
      "submit the cases of the files that are there, or wait until they have expired";

  while (held_->of(user) + announced.size_bytes() > limits_.of_user)
    if (!remove_oldest_used(&user))
      throw refuse(announced, "per_user.maximum_uploads",
                   fmt::format("{} together", megabytes(limits_.of_user)),
                   fmt::format("does not fit beside the {} that {} has uploaded and not used",
                               megabytes(held_->of(user)), user),
                   remedy);

  while (held_->all() + announced.size_bytes() > limits_.all)
    if (!remove_oldest_used(nullptr))
      throw refuse(
          announced, "limits.maximum_uploads", fmt::format("{} together", megabytes(limits_.all)),
          fmt::format("does not fit beside the {} of all users", megabytes(held_->all())), remedy);
}

/// Removes the least recently used file, unless a call is reading it.
/// @param user  owner of the file; null: any user
/// @return      false if there is no such file
bool Uploads::remove_oldest_used(const std::string* user) {
  auto oldest = files_.end();
  for (auto file = files_.begin(); file != files_.end(); ++file) {
    const Entry& entry = file->second;
    const bool may_go = entry.was_used && entry.file.use_count() == 1 &&
                        (user == nullptr || file->first.first == *user);
    if (may_go && (oldest == files_.end() || entry.last_used < oldest->second.last_used))
      oldest = file;
  }
  if (oldest == files_.end()) return false;
  files_.erase(oldest);
  return true;
}

void Uploads::keep(const Key& key, std::shared_ptr<const StagedFile> file) {
  const std::lock_guard lock(mutex_);
  // Concurrent uploads of the same file may both finish: the first one is kept.
  Entry& entry = files_[key];
  if (!entry.file) entry.file = std::move(file);
  entry.last_used = Clock::now();
}

void Uploads::remove_expired() {
  const auto oldest = Clock::now() - limits_.lifetime;
  std::erase_if(files_, [&](const auto& file) { return file.second.last_used < oldest; });
}

void Uploads::watch_for_expiry(const std::stop_token& stop) {
  const auto between_looks =
      std::min<Clock::duration>(limits_.lifetime / 2, std::chrono::minutes(1));
  std::condition_variable_any ended;
  std::unique_lock lock(mutex_);
  while (!ended.wait_for(lock, stop, between_looks, [&] { return stop.stop_requested(); }))
    remove_expired();
}

Uploads::Upload::Upload(Uploads& uploads, std::string user, const v1::Attachment& announced,
                        std::shared_ptr<StagedFile> file)
    : uploads_(uploads),
      user_(std::move(user)),
      sha256_(announced.sha256()),
      announced_bytes_(announced.size_bytes()),
      staged_(std::move(file)),
      file_(staged_->path(), O_WRONLY | O_CREAT | O_EXCL) {}

Uploads::Upload::~Upload() {
  uploads_.end_upload(user_);
}

void Uploads::Upload::append(std::string_view chunk) {
  const std::int64_t end = written_ + static_cast<std::int64_t>(chunk.size());
  if (end > announced_bytes_)
    throw UploadBroken(fmt::format("more than the {} bytes of size_bytes came", announced_bytes_));

  file_.write_at(written_, chunk);
  digest_.add(chunk);
  written_ = end;
}

void Uploads::Upload::finish() {
  if (written_ != announced_bytes_)
    throw UploadBroken(
        fmt::format("{} bytes came, and size_bytes is {}", written_, announced_bytes_));
  if (const std::string sha256 = digest_.finish(); sha256 != sha256_)
    throw UploadBroken(
        fmt::format("the received file has the SHA-256 {}, not {}; it may have changed "
                    "meanwhile: upload it again",
                    sha256, sha256_));
  uploads_.keep({user_, sha256_}, staged_);
}

}  // namespace dccast::intake
