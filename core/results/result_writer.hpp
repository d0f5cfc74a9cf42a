#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/results/frame.hpp"
#include "core/results/journal.hpp"
#include "core/results/step_report.hpp"

namespace dccast::results {

/// The files of a run: the journal during the run and the final results.
struct RunFiles {
  std::filesystem::path journal;
  /// results.h5; while it is being written `.part` is appended to its name.
  std::filesystem::path results;
};

/// Section of a checkpoint with the number of records in the journal.
inline constexpr const char* journal_records = "journal_records";

struct ResumedWriter;

/// Collects the steps and frames of a run and makes its result file.
///
/// They are appended to a journal (CHECKPOINT.md), from which a background thread writes HDF5
/// (SCHEMA.md) during the run. A run is resumed from the journal, not from the HDF5 file: a run
/// that is killed at any time and resumed from its checkpoint gives the same file, byte for byte,
/// as an uninterrupted one.
///
/// All calls may throw storage::StorageError, also for a failure of the background thread since the
/// last call.
class ResultWriter {
public:
  /// Starts the results of a run; existing ones are overwritten.
  static ResultWriter create(const RunFiles& files, const RunHeader& header);

  /// Continues after step `step`, at which there is a checkpoint; later steps and frames are
  /// discarded. Returns a reason instead of a writer if the journal is missing, damaged, ends
  /// before that step or has fewer records up to it than the checkpoint says: the run then starts
  /// from the beginning.
  /// @param records  journal_records of the checkpoint; 0: unknown
  static ResumedWriter resume(const RunFiles& files, std::int64_t step, std::int64_t records = 0);

  ResultWriter(ResultWriter&&) noexcept;
  ResultWriter& operator=(ResultWriter&&) noexcept;
  /// Finishes pending work. Of unpublished results only the journal remains.
  ~ResultWriter();

  /// Calls `visit` with every step of the journal after step `after`, in order.
  void visit_steps(std::int64_t after, const std::function<void(const StepReport&)>& visit) const;

  void append(const StepReport& report);
  /// @param frame  of the last step appended, or of the initial state
  void append(const Frame& frame);

  /// Hands the appended records to the operating system, so that they survive the end of this
  /// process, and adds them to the result file. To be called at each frame.
  void flush();
  /// Syncs the journal to disk and then writes a checkpoint, with journal_records added. Both are
  /// done by the background thread; see wait().
  void checkpoint(const std::filesystem::path& path, Sections content);
  /// Waits until all pending work of the background thread is on disk.
  void wait();

  /// Completes `results`.part and renames it to its final name; does the same with the XDMF
  /// sidecar, `results` with extension .xdmf. The journal remains until remove_journal().
  void publish(const RunSummary& summary);
  void remove_journal();

private:
  struct Parts;
  explicit ResultWriter(std::unique_ptr<Parts> parts);
  void append(RecordKind kind, const Sections& content);

  std::unique_ptr<Parts> parts_;
};

struct ResumedWriter {
  std::optional<ResultWriter> writer;
  std::string reason;  ///< why there is no writer
};

}  // namespace dccast::results
