#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "core/results/durable_file.hpp"
#include "core/results/frame.hpp"
#include "core/results/sections.hpp"
#include "core/results/step_report.hpp"

namespace dccast::results {

/// What a record of a journal is; the numbers stand in the file.
enum class RecordKind : std::uint8_t { header = 1, step = 2, frame = 3 };

/// The records of a run while it is going on, appended to one file; format in CHECKPOINT.md.
class Journal {
public:
  /// Begins a new file, over one that may be there. @throws StorageError
  static Journal create(const std::filesystem::path& path);
  /// Goes on with a file, cut off behind byte `size`. @throws StorageError
  static Journal reopen(const std::filesystem::path& path, std::uint64_t size);

  /// Puts a record behind the others; in memory until write().
  void append(RecordKind kind, const Sections& content);
  /// Hands the records to the system: they outlive this process. @throws StorageError
  void write();
  /// Waits until what write() handed over is on the disk; also from another thread.
  /// @throws StorageError
  void sync() { file_.sync(); }

private:
  explicit Journal(FileDescriptor file) : file_(std::move(file)) {}

  FileDescriptor file_;
  std::string pending_;
};

/// One whole record of a journal.
struct Record {
  RecordKind kind{};
  Sections content;
  std::uint64_t end = 0;  ///< byte behind the record
};

/// Calls `visit` with each whole record in turn until it answers false; stops before a damaged one.
/// @param after  begin behind this byte, the end of a record visited before; 0: at the beginning
/// @return false when the file does not begin like a journal
/// @throws StorageError  the file cannot be read
bool visit_journal(const std::filesystem::path& path,
                   const std::function<bool(const Record&)>& visit, std::uint64_t after = 0);

Sections to_sections(const RunHeader& header);
Sections to_sections(const StepReport& report);
Sections to_sections(const Frame& frame);
/// @throws std::out_of_range  a section is missing: the record was written by other software
RunHeader header_of(const Sections& content);
StepReport step_of(const Sections& content);
Frame frame_of(const Sections& content);

}  // namespace dccast::results
