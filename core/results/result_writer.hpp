#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/restart/journal.hpp"
#include "core/results/frame.hpp"
#include "core/results/step_report.hpp"

namespace dccast::results {

/// Where the records of a run go while it goes on, and what they become.
struct RunFiles {
  std::filesystem::path journal;
  /// results.h5; while it is written it has the extension .part behind its name.
  std::filesystem::path results;
};

/// Section of a checkpoint that says how many records the journal held.
inline constexpr const char* journal_records = "journal_records";

struct ResumedWriter;

/// Collects the steps and frames of a run and makes its result file.
///
/// They are appended to a journal (CHECKPOINT.md), out of which a thread makes HDF5 as SCHEMA.md
/// says while the run goes on. The journal alone is what a run is resumed from: one that is killed
/// at any moment and resumed from its checkpoint therefore gives the same file, byte for byte, as
/// one that was not.
///
/// All calls may throw storage::StorageError, also for what the thread could not write since the
/// last call.
class ResultWriter {
public:
  /// Begins the results of a run, over older ones.
  static ResultWriter create(const RunFiles& files, const RunHeader& header);

  /// Goes on after step `step`, of which there is a checkpoint; later steps and frames are dropped.
  /// No writer, but the reason, when the journal is missing, damaged, ends before that step or has
  /// fewer records up to it than the checkpoint says: the run then starts over.
  /// @param records  journal_records of the checkpoint; 0: not known
  static ResumedWriter resume(const RunFiles& files, std::int64_t step, std::int64_t records = 0);

  ResultWriter(ResultWriter&&) noexcept;
  ResultWriter& operator=(ResultWriter&&) noexcept;
  /// Work under way is finished first. Nothing but the journal stays of unpublished
  /// results.
  ~ResultWriter();

  /// Calls `visit` with every step of the journal after step `after`, in their order.
  void visit_steps(std::int64_t after, const std::function<void(const StepReport&)>& visit) const;

  void append(const StepReport& report);
  /// @param frame  of the last step appended, or of the initial state
  void append(const Frame& frame);

  /// Makes what was appended outlive this process, and part of the result file. Call it at each
  /// frame.
  void flush();
  /// Writes a checkpoint, with journal_records added, once what was appended would outlive a loss
  /// of power. The thread does both; see wait().
  void checkpoint(const std::filesystem::path& path, restart::Sections content);
  /// Waits for the thread: what was posted is on the disk.
  void wait();

  /// Writes what is missing of `results`.part, gives it its name once it is whole, and does the
  /// same with the XDMF sidecar, `results` with extension .xdmf. The journal stays until
  /// remove_journal().
  void publish(const RunSummary& summary);
  void remove_journal();

private:
  struct Parts;
  explicit ResultWriter(std::unique_ptr<Parts> parts);
  void append(restart::RecordKind kind, const restart::Sections& content);

  std::unique_ptr<Parts> parts_;
};

struct ResumedWriter {
  std::optional<ResultWriter> writer;
  std::string reason;  ///< why there is none
};

}  // namespace dccast::results
