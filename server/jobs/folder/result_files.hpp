#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <stdexcept>
#include <string>

#include "core/storage/file.hpp"
#include "dccast/v1/job.pb.h"

namespace dccast::jobs {

/// A result on the disk differs from what its worker published, or cannot be read. The text is for
/// callers: it names the file without its folder, and the remedy.
class UnsoundResult : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// Opens a result of an ended job for reading. Of its content only the size is checked.
/// @throws UnsoundResult  it is missing, cannot be opened, or has another size
/// @throws storage::StorageError  the machine lacks something, such as file descriptors
storage::File open_result(const std::filesystem::path& job_folder, const v1::Artifact& artifact);

/// Checks results against the SHA-256 that their workers reported, before they are shown. A file
/// that has not changed since its last check is not read again. Safe to use from several threads.
class ResultDigests {
public:
  /// @throws UnsoundResult  also if the digest differs
  /// @throws storage::StorageError  as open_result()
  void require_sound(const std::filesystem::path& job_folder, const v1::Artifact& artifact);

private:
  /// Device, inode, size and the times of the last changes of content and inode [ns].
  using State = std::array<std::int64_t, 5>;
  static State examine(const storage::File& file);

  std::mutex mutex_;
  std::map<std::filesystem::path, State> sound_;
};

}  // namespace dccast::jobs
