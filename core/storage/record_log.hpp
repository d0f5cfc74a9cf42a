#pragma once

#include <cstdint>
#include <mutex>
#include <string_view>

#include "core/storage/file.hpp"

namespace dccast::storage {

/// A file that grows at its end by whole records, and of which only a tail is ever cut off. One
/// thread appends while another waits for the disk. All calls that touch the file throw
/// StorageError.
class RecordLog {
public:
  /// Goes on behind what the file holds.
  explicit RecordLog(File file);

  const File& file() const { return file_; }
  std::int64_t end() const;  ///< byte behind the last record

  /// Puts whole records behind the others. When it throws, also because of an earlier sync(), the
  /// file is as it was. @return the byte at which they begin
  std::int64_t append(std::string_view records);

  /// Cuts off what stands behind byte `end`.
  void cut(std::int64_t end);

  /// Waits until what was appended is on the disk; cheap when nothing was. Once it has failed the
  /// log takes nothing more.
  void sync();

private:
  File file_;
  std::mutex sync_mutex_;  ///< one sync at a time; appends go on meanwhile
  mutable std::mutex mutex_;
  std::int64_t end_ = 0;
  std::int64_t synced_ = 0;
  int sync_error_ = 0;  ///< errno of a sync that failed
};

}  // namespace dccast::storage
