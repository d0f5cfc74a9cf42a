#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/results/frame.hpp"
#include "core/results/journal.hpp"
#include "core/results/levers_group.hpp"
#include "core/results/step_report.hpp"
#include "core/storage/background.hpp"

namespace dccast::results {

/// The files of a run: the journal during the run and the final results.
struct RunFiles {
  /// File to which frames and headers are appended while the run goes on.
  std::filesystem::path journal;
  /// results.h5; while it is being written `.part` is appended to its name.
  std::filesystem::path results;
};

/// Section of a checkpoint with the number of records in the journal.
inline constexpr const char* journal_records = "journal_records";

struct ResumedWriter;
class ResultFileBuilder;

/// Collects the steps and frames of a run and makes its result file.
///
/// Frames are appended to a journal (CHECKPOINT.md), from which a background thread writes HDF5
/// (SCHEMA.md) during the run. Steps stay in memory until the end: the observer of
/// the run keeps them (StepObserver) and gives them back to a run that is resumed. A run is resumed
/// from the journal, not from the HDF5 file: a run that is killed at any time and resumed from its
/// checkpoint gives the same file, byte for byte, as an uninterrupted one.
///
/// All calls may throw storage::StorageError, also for a failure of the background thread since the
/// last call.
class ResultWriter {
public:
  /// Starts the results of a run; existing ones are overwritten.
  ResultWriter(RunFiles files, const RunHeader& header);

  /// Continues after the last step of `history`, at which there is a checkpoint; later frames are
  /// discarded. Returns a reason instead of a writer if the journal is missing, damaged or has
  /// fewer records up to that step than the checkpoint says: the run then starts from the
  /// beginning.
  /// @param history  all steps up to the checkpoint
  /// @param records  journal_records of the checkpoint
  static ResumedWriter resume(const RunFiles& files, std::vector<StepReport> history,
                              std::int64_t records);

  /// Not copied: the background thread holds its address.
  ResultWriter(const ResultWriter&) = delete;
  /// Finishes pending work. Of unpublished results only the journal remains.
  ~ResultWriter();

  /// Keeps the report of a step for the history. Reports are written at the end only.
  void append(const StepReport& report);
  /// @param frame  of the last step appended, or of the initial state
  void append(const Frame& frame);

  /// Time of the last frame, also of one that a resumed run finds in the journal [s]; empty: none
  /// yet.
  std::optional<double> last_frame_time() const { return last_frame_time_; }

  /// Hands the appended records to the operating system, so that they survive the end of this
  /// process, and adds them to the result file. To be called at each frame.
  void flush();
  /// Syncs the journal to disk and then writes a checkpoint, with journal_records added. Both are
  /// done by the background thread; see wait().
  /// @param sync_steps  called before by that thread: the steps are on the disk when it returns
  void checkpoint(const std::filesystem::path& path, Sections content,
                  std::function<void()> sync_steps = {});
  /// Waits until all pending work of the background thread is on disk.
  void wait();

  /// Completes `results`.part and renames it to its final name; does the same with the XDMF
  /// sidecars, `results` with extension .xdmf and "-end.xdmf". The journal remains.
  /// @param levers  of a casting that was followed
  void publish(const RunSummary& summary, const MeasuredLevers& levers = {});

private:
  /// A place in the journal after which a run goes on.
  struct Cut;
  /// The end of the records up to a step; empty if the file is not a journal or a record is
  /// incomplete.
  static std::optional<Cut> find_cut(const std::filesystem::path& journal, std::int64_t step);
  /// Continues with the records that the journal and the reports still hold.
  ResultWriter(RunFiles files, const Cut& cut, std::vector<StepReport> history);
  /// Appends a record and counts it.
  void append_record(RecordKind kind, const Sections& content);

  // Called by the background thread.
  void follow();
  /// Writes the result file beside its final name and publishes it.
  void finish(const RunSummary& summary, const MeasuredLevers& levers);
  std::unique_ptr<ResultFileBuilder> take_builder();

  RunFiles files_;
  Journal journal_;
  std::int64_t records_ = 0;               ///< appended to the journal
  std::optional<double> last_frame_time_;  ///< [s]
  std::vector<StepReport> history_;        ///< read by the thread in finish(), when no step follows
  std::unique_ptr<ResultFileBuilder> builder_;  ///< used by the background thread only
  /// Last member: its thread ends before the others are destroyed.
  storage::Background background_;
};

/// Result of ResultWriter::resume().
struct ResumedWriter {
  /// Absent if the run cannot be continued with these files.
  std::unique_ptr<ResultWriter> writer;
  std::string reason;  ///< why there is no writer
};

}  // namespace dccast::results
