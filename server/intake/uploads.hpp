#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "core/storage/file.hpp"
#include "dccast/v1/job.pb.h"
#include "proto/refusal/refusal.hpp"
#include "proto/values/digests.hpp"
#include "server/jobs/folder/job_folder.hpp"

namespace dccast::intake {

/// A limit refuses an upload. The fault gives the value, the permitted range and the remedy.
class UploadRefused : public refusal::LimitReached {
public:
  UploadRefused(refusal::Facts facts, v1::Fault fault);
  const v1::Fault& fault() const { return fault_; }

private:
  v1::Fault fault_;
};

/// Too many uploads are under way; a further one must wait.
class TooManyUploads : public std::runtime_error {
  using runtime_error::runtime_error;
};

/// The received bytes are not the announced file.
class UploadBroken : public std::runtime_error {
  using runtime_error::runtime_error;
};

/// Files that users have uploaded for cases to be submitted. A file belongs to its uploader alone:
/// knowing the SHA-256 of another user's file gives no access to it. Files are stored in a folder
/// of the data directory. They are removed by age, in favour of newer ones, and at each start of
/// the daemon; jobs have copies. Safe to use from several threads; outlives its uploads.
class Uploads {
public:
  struct Limits {
    std::int64_t largest = 0;       ///< size of one file [bytes]
    std::int64_t of_user = 0;       ///< total size of one user's files [bytes]
    std::int64_t all = 0;           ///< total size of all files [bytes]
    std::int64_t minimum_free = 0;  ///< free space left on the disk [bytes]
    std::chrono::steady_clock::duration lifetime = std::chrono::hours(1);
    int at_once_of_user = 24;  ///< concurrent uploads of one user
    int at_once = 32;          ///< concurrent uploads of all users
  };

  /// @param directory  created if missing, and emptied @throws std::filesystem::filesystem_error
  Uploads(std::filesystem::path directory, const Limits& limits);

  /// Finds a file that a user has uploaded and a case names; empty if there is none.
  std::optional<jobs::AttachedFile> find(const std::string& user, const v1::Attachment& named);

  /// Restarts the lifetime of a file that the user is about to use. @return whether it exists
  bool renew(const std::string& user, const v1::Attachment& announced);

  class Upload;
  /// Begins an upload. @param announced  SHA-256 and size that the file must have
  /// @throws UploadRefused, TooManyUploads, std::system_error  the disk takes nothing
  std::unique_ptr<Upload> begin(const std::string& user, const v1::Attachment& announced);

  /// Disk space of all files, complete or not [bytes].
  std::int64_t bytes() const { return held_->all(); }

private:
  using Clock = std::chrono::steady_clock;

  /// Bytes held, by user.
  class Held {
  public:
    void change(const std::string& user, std::int64_t bytes);
    std::int64_t of(const std::string& user) const;
    std::int64_t all() const;

  private:
    mutable std::mutex mutex_;
    std::map<std::string, std::int64_t> of_user_;
    std::int64_t all_ = 0;
  };

  /// A file on disk. The destructor removes it and releases its share of the limits.
  class StagedFile {
  public:
    StagedFile(std::shared_ptr<Held> held, std::string user, std::int64_t bytes,
               std::filesystem::path path);
    StagedFile(const StagedFile&) = delete;
    ~StagedFile();
    const std::filesystem::path& path() const { return path_; }
    const std::string& user() const { return user_; }
    std::int64_t bytes() const { return bytes_; }

  private:
    const std::shared_ptr<Held> held_;
    const std::string user_;
    const std::int64_t bytes_;
    const std::filesystem::path path_;
  };

  struct Entry {
    std::shared_ptr<const StagedFile> file;
    Clock::time_point last_used;
    bool was_used = false;  ///< by a call that named it
  };
  using Key = std::pair<std::string, std::string>;  ///< user, SHA-256

  void keep(const Key& key, std::shared_ptr<const StagedFile> file);
  void end_upload(const std::string& user);
  void count_upload(const std::string& user);
  void make_room(const std::string& user, const v1::Attachment& announced);
  bool remove_oldest_used(const std::string* user);
  void remove_expired();
  void watch_for_expiry(const std::stop_token& stop);

  const std::filesystem::path directory_;
  const Limits limits_;
  const std::shared_ptr<Held> held_ = std::make_shared<Held>();
  std::mutex mutex_;  ///< guards the members below
  std::map<Key, Entry> files_;
  std::map<std::string, int> under_way_;  ///< uploads by user
  std::jthread watcher_;
};

/// An upload in progress. Destruction before finish() removes the received bytes.
class Uploads::Upload {
public:
  Upload(Uploads& uploads, std::string user, const v1::Attachment& announced,
         std::shared_ptr<StagedFile> file);
  Upload(const Upload&) = delete;
  ~Upload();

  /// @throws UploadBroken  more than was announced; std::system_error
  void append(std::string_view chunk);
  /// Makes the file available. @throws UploadBroken  it is not the announced file
  void finish();

private:
  Uploads& uploads_;
  const std::string user_, sha256_;
  const std::int64_t announced_bytes_;
  std::shared_ptr<StagedFile> staged_;
  storage::File file_;
  values::Sha256 digest_;
  std::int64_t written_ = 0;
};

}  // namespace dccast::intake
