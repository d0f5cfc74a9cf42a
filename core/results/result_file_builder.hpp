#pragma once

#include <filesystem>
#include <vector>

#include "core/hdf5/hdf5_file.hpp"
#include "core/restart/journal.hpp"
#include "core/results/frame.hpp"
#include "core/results/step_report.hpp"

namespace dccast::results {

/// Makes results.h5 out of the journal of a run, also while the journal still grows: what is in the
/// file depends on the records and their order alone. One frame is in memory at a time.
///
/// All calls may throw storage::StorageError.
class ResultFileBuilder {
public:
  /// @param results  the file to write, over an older one
  ResultFileBuilder(std::filesystem::path journal, const std::filesystem::path& results);

  /// Takes over the records that have come since.
  void follow();
  /// follow(), then what can be written at the end only; closes the file.
  void finish(const RunSummary& summary);

  /// Of the frames so far, for the sidecar.
  const std::vector<FrameOutline>& frames() const { return frames_; }

private:
  void take(const restart::Record& record);

  std::filesystem::path journal_;
  std::int64_t journal_end_ = 0;  ///< byte behind the last record taken over
  hdf5::File file_;
  std::size_t monitors_ = 0;
  int dimension_ = 2;
  std::vector<StepReport> steps_;
  std::vector<FrameOutline> frames_;
};

}  // namespace dccast::results
