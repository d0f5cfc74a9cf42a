#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/results/frame.hpp"
#include "core/results/journal.hpp"
#include "core/results/step_report.hpp"

namespace dccast::results {

struct ResumedWriter;

/// Collects the steps and frames of a run and makes its result file.
///
/// While the run goes on they are appended to a journal (CHECKPOINT.md); publish() turns it into
/// HDF5 as SCHEMA.md says. A run that is killed at any moment and resumed from its checkpoint
/// therefore gives the same file, byte for byte, as one that was not.
///
/// All calls may throw StorageError.
class ResultWriter {
public:
  /// Begins the results of a run. @param journal  path of the journal, over an older one
  static ResultWriter create(const std::filesystem::path& journal, const RunHeader& header);

  /// Goes on after step `step`, of which there is a checkpoint; later steps and frames are dropped.
  /// No writer, but the reason, when the journal is missing, damaged or ends before that step: the
  /// run then begins anew.
  static ResumedWriter resume(const std::filesystem::path& journal, std::int64_t step);

  void append(const StepReport& report);
  /// @param frame  of the last step appended, or of the initial state
  void append(const Frame& frame);

  /// Makes what was appended outlive this process. Call it at each frame.
  void flush() { journal_.write(); }
  /// Makes what was appended outlive a loss of power. Call it before each checkpoint is written.
  void sync() { journal_.sync(); }

  /// Writes the HDF5 file beside `results` as `results`.part, gives it its name once it is whole,
  /// and does the same with the XDMF sidecar `results` with extension .xdmf. The journal stays
  /// until remove_journal().
  void publish(const std::filesystem::path& results, const RunSummary& summary);
  void remove_journal();

private:
  ResultWriter(std::filesystem::path path, Journal journal)
      : journal_path_(std::move(path)), journal_(std::move(journal)) {}

  std::filesystem::path journal_path_;
  Journal journal_;
};

struct ResumedWriter {
  std::optional<ResultWriter> writer;
  std::string reason;  ///< why there is none
};

/// Writes results.h5 from the journal of a run. @throws StorageError
void write_result_file(const std::filesystem::path& journal, const std::filesystem::path& results,
                       const RunSummary& summary);

}  // namespace dccast::results
