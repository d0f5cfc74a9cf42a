#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/results/frame.hpp"
#include "core/results/levers_group.hpp"
#include "core/results/step_report.hpp"

/// Names in results.h5, shared by writer, reader and sidecar. SCHEMA.md is the specification.
namespace dccast::results {

/// Incremented when a dataset changes or is removed, not when one is added.
inline constexpr int schema_version = 3;

/// Group of a frame, e.g. "/frames/000012".
std::string frame_group(std::size_t index);
/// Dataset of a field, e.g. "/history/time_s".
inline std::string history_dataset(const std::string& field) {
  return std::string("/history/") + field;
}

}  // namespace dccast::results

namespace dccast::results::hdf5 {
class File;
}

namespace dccast::results {

/// Reads a result file. All calls may throw storage::StorageError, which names file and dataset.
class ResultReader {
public:
  /// @throws storage::StorageError  also for an unknown schema version
  explicit ResultReader(const std::filesystem::path& results);
  /// A reader owns the open file.
  ResultReader(ResultReader&&) noexcept;
  ~ResultReader();

  /// Data stored once per run. @throws storage::StorageError  the file is damaged
  RunHeader header() const;
  RunSummary summary() const;
  MeasuredLevers levers() const;  ///< of a casting that the run followed
  /// All accepted steps. Computing times are not stored, so they are zero.
  std::vector<StepReport> history() const;
  std::size_t frames() const { return frames_; }
  /// Times of all stored frames [s].
  std::vector<double> frame_times() const;
  /// @pre index < frames()
  Frame frame(std::size_t index) const;

private:
  std::unique_ptr<hdf5::File> file_;
  std::size_t frames_ = 0;
};

}  // namespace dccast::results
