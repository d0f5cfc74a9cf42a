#pragma once

#include <cstdint>
#include <mutex>
#include <string_view>

#include "core/storage/file.hpp"
#include "core/storage/record_format.hpp"

namespace dccast::storage {

/// An append-only file of complete records; the only other change is to truncate it. One thread may
/// append while another one syncs. All calls that access the file throw StorageError.
class RecordLog {
public:
  /// Continues after the present content of the file.
  explicit RecordLog(File file);

  const File& file() const { return file_; }
  std::int64_t end() const;  ///< byte after the last record

  /// Appends complete records. If it throws, also because of an earlier failure of sync(), the file
  /// is unchanged. @return the byte at which they begin
  std::int64_t append(std::string_view records);

  /// Truncates the file to `end` bytes. The next sync() syncs all of it. This ends a failure of
  /// sync(): bytes that it left in doubt are truncated, or written again if they lie before `end`.
  void cut(std::int64_t end);

  /// Waits until all appended records are on disk; cheap if there are no new ones. After a failure
  /// the log accepts no more records until cut().
  void sync();
  /// Whether the last sync() failed, and no cut() has followed.
  bool in_doubt() const;

private:
  /// Writes a range of the file again. After a failed sync the kernel marks pages as clean: only a
  /// new write makes the next sync write them.
  void write_again(std::int64_t begin, std::int64_t end) const;

  File file_;
  std::mutex sync_mutex_;  ///< one sync at a time; appends are possible meanwhile
  mutable std::mutex mutex_;
  std::int64_t end_ = 0;     ///< byte after the last record
  std::int64_t synced_ = 0;  ///< byte up to which the file is on disk
  int sync_error_ = 0;       ///< errno of a sync that failed
};

}  // namespace dccast::storage
