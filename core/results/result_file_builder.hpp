#pragma once

#include <filesystem>
#include <vector>

#include "core/results/frame.hpp"
#include "core/results/hdf5_file.hpp"
#include "core/results/journal.hpp"
#include "core/results/levers_group.hpp"
#include "core/results/step_report.hpp"
#include "core/results/xdmf.hpp"

namespace dccast::results {

/// Creates results.h5 from the journal of a run, also while the journal still grows: the content of
/// the file depends only on the records and their order. One frame is in memory at a time.
///
/// All calls may throw storage::StorageError.
class ResultFileBuilder {
public:
  /// @param results  the file to write; an existing one is overwritten
  ResultFileBuilder(std::filesystem::path journal, const std::filesystem::path& results);

  /// Adds the records that were appended to the journal since the last call.
  void follow();
  /// Calls follow(), writes the data that are known only at the end, and closes the file.
  /// @param history  one report per accepted step
  void finish(const RunSummary& summary, const MeasuredLevers& levers,
              const std::vector<StepReport>& history);

  /// Outlines of the frames so far, for the sidecar.
  const std::vector<FrameOutline>& frames() const { return frames_; }

private:
  /// Adds a record of the journal. @throws storage::StorageError
  void add(const Record& record);

  /// Read again for the frames, which are not kept in memory.
  std::filesystem::path journal_;
  std::int64_t journal_end_ = 0;  ///< byte after the last record that was added
  hdf5::File file_;
  std::size_t monitors_ = 0;
  int dimension_ = 2;
  std::vector<FrameOutline> frames_;
};

}  // namespace dccast::results
