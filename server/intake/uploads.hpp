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
#include "proto/values/digests.hpp"
#include "server/jobs/folder/job_folder.hpp"

namespace dccast::intake {

/// An upload is not taken: a limit. The fault names what was given, what is permitted, the remedy.
class UploadRefused : public std::runtime_error {
public:
  explicit UploadRefused(v1::Fault fault);
  const v1::Fault& fault() const { return fault_; }

private:
  v1::Fault fault_;
};

/// So many uploads are under way that a further one has to wait.
class TooManyUploads : public std::runtime_error {
  using runtime_error::runtime_error;
};

/// What came is not the file that was announced.
class UploadBroken : public std::runtime_error {
  using runtime_error::runtime_error;
};

/// Files that users have uploaded for cases that are still to come. Each is its uploader's alone:
/// knowing the SHA-256 of another user's file gives no access to it. The files lie in a folder of
/// the data directory and are removed by age, for newer ones, and all of them at a start of the
/// daemon; a job has copies. Safe to use from several threads; outlives its uploads.
class Uploads {
public:
  struct Limits {
    std::int64_t largest = 0;       ///< file [bytes]
    std::int64_t of_user = 0;       ///< files of one user together [bytes]
    std::int64_t all = 0;           ///< files of all users together [bytes]
    std::int64_t minimum_free = 0;  ///< on the disk, beside the file [bytes]
    std::chrono::steady_clock::duration lifetime = std::chrono::hours(1);
    int at_once_of_user = 24;  ///< uploads under way
    int at_once = 32;          ///< the same of all users
  };

  /// @param directory  made if need be, and emptied @throws std::filesystem::filesystem_error
  Uploads(std::filesystem::path directory, const Limits& limits);

  /// The file that a user's case names, which was uploaded before; nothing where there is none.
  std::optional<jobs::AttachedFile> find(const std::string& user, const v1::Attachment& named);

  /// Whether the file is there for this user, who is about to use it.
  bool renew(const std::string& user, const v1::Attachment& announced);

  class Upload;
  /// Begins to take a file. @param announced  its SHA-256 and size are held against what comes
  /// @throws UploadRefused, TooManyUploads, std::system_error  the disk takes nothing
  std::unique_ptr<Upload> begin(const std::string& user, const v1::Attachment& announced);

  /// What all files hold, also those that are not complete yet [bytes].
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

  /// A file on the disk, which goes with this object, as does its share of what is held.
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
  std::mutex mutex_;  ///< of all below
  std::map<Key, Entry> files_;
  std::map<std::string, int> under_way_;  ///< uploads by user
  std::jthread watcher_;
};

/// One upload under way. Its end before finish() removes what has come.
class Uploads::Upload {
public:
  Upload(Uploads& uploads, std::string user, const v1::Attachment& announced,
         std::shared_ptr<StagedFile> file);
  Upload(const Upload&) = delete;
  ~Upload();

  /// @throws UploadBroken  more than was announced; std::system_error
  void append(std::string_view chunk);
  /// From now on the file is found. @throws UploadBroken  it is not what was announced
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
