#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "core/restart/sections.hpp"
#include "core/storage/record_log.hpp"

namespace dccast::restart {

/// What a record of a journal is; the numbers stand in the file.
enum class RecordKind : std::uint8_t { header = 1, step = 2, frame = 3 };

/// The records of a run while it is going on, appended to one file; format in CHECKPOINT.md. All
/// calls may throw storage::StorageError.
class Journal {
public:
  /// Begins a new file, over one that may be there.
  static Journal create(const std::filesystem::path& path);
  /// Goes on with a file, cut off behind byte `size`.
  static Journal reopen(const std::filesystem::path& path, std::int64_t size);

  /// Puts a record behind the others; in memory until write().
  void append(RecordKind kind, const Sections& content);
  /// Hands the records to the system: they outlive this process.
  void write();
  /// Waits until what write() handed over is on the disk; also from another thread.
  void sync() { log_->sync(); }

private:
  explicit Journal(storage::File file);

  std::unique_ptr<storage::RecordLog> log_;  ///< at one address for the thread that synchronises
  std::string pending_;
};

/// One whole record of a journal.
struct Record {
  RecordKind kind{};
  Sections content;
  std::int64_t end = 0;  ///< byte behind the record
};

/// Calls `visit` with each whole record in turn until it answers false; stops before a damaged one.
/// @param after  begin behind this byte, the end of a record visited before; 0: at the beginning
/// @return false when the file does not begin like a journal
/// @throws storage::StorageError  the file cannot be read
bool visit_journal(const std::filesystem::path& path,
                   const std::function<bool(const Record&)>& visit, std::int64_t after = 0);

}  // namespace dccast::restart
