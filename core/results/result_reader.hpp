#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "core/results/frame.hpp"
#include "core/results/step_report.hpp"

namespace dccast::hdf5 {
class File;
}

namespace dccast::results {

/// Reads a result file. All calls may throw storage::StorageError, which names file and dataset.
class ResultReader {
public:
  /// @throws storage::StorageError  also for an unknown schema version
  explicit ResultReader(const std::filesystem::path& results);
  ResultReader(ResultReader&&) noexcept;
  ~ResultReader();

  RunHeader header() const;
  RunSummary summary() const;
  /// All accepted steps. Computing times are not stored, so they are zero.
  std::vector<StepReport> history() const;
  std::size_t frames() const { return frames_; }
  /// Times of all stored frames [s].
  std::vector<double> frame_times() const;
  /// @pre index < frames()
  Frame frame(std::size_t index) const;
  /// Empty if the run stored no frame.
  std::optional<Frame> last_frame() const;

private:
  std::unique_ptr<hdf5::File> file_;
  std::size_t frames_ = 0;
};

}  // namespace dccast::results
