#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "core/results/frame.hpp"
#include "core/results/sections.hpp"
#include "core/storage/record_log.hpp"

namespace dccast::results {

/// Kind of a journal record; the numbers are part of the file format.
enum class RecordKind : std::uint8_t { header = 1, frame = 2 };

/// The records of a running casting, appended to one file; CHECKPOINT.md has the format. All calls
/// may throw storage::StorageError.
class Journal {
public:
  /// Creates a new file; an existing one is overwritten.
  explicit Journal(const std::filesystem::path& path);
  /// Opens a file for appending, truncated to `size` bytes.
  Journal(const std::filesystem::path& path, std::int64_t size);

  /// Appends a record; it stays in memory until write().
  void append(RecordKind kind, const Sections& content);
  /// Hands the records to the operating system: they survive the end of this process.
  void write();
  /// Waits until everything passed to write() is on disk; may be called from another thread.
  void sync() { log_.sync(); }

private:
  storage::RecordLog log_;
  std::string pending_;  ///< records that write() has not written yet
};

/// One whole record of a journal.
struct Record {
  /// Kind of the record and its content.
  RecordKind kind{};
  Sections content;
  std::int64_t end = 0;  ///< byte after the record
};

/// Calls `visit` with each complete record in order until it returns false; stops at a damaged one.
/// @param after  start after this byte, the end of a record visited before; 0: at the beginning
/// @return false if the file does not begin like a journal
/// @throws storage::StorageError  the file cannot be read
bool visit_journal(const std::filesystem::path& path,
                   const std::function<bool(const Record&)>& visit, std::int64_t after = 0);

/// Conversion of the header and a frame of a run to the sections of a journal record, and back.
Sections to_sections(const RunHeader& header);
Sections to_sections(const Frame& frame);
/// @throws std::out_of_range  a section is missing: the record was written by other software
RunHeader read_header(const Sections& content);
/// @throws std::out_of_range  as read_header()
Frame read_frame(const Sections& content);

}  // namespace dccast::results
