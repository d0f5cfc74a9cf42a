#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "core/results/frame.hpp"
#include "core/results/result_reader.hpp"

namespace dccast::worker {

/// The frames that a run has stored: in results.h5, or in the journal of a run that has not ended.
///
/// A run appends to its journal meanwhile; a record that is not complete yet ends what is read.
class StoredFrames {
public:
  /// @param directory  of the job; a run that has not begun has no journal and no frames
  /// @throws storage::StorageError  the file cannot be read
  StoredFrames(const std::filesystem::path& directory, bool running);

  const results::RunHeader& header() const { return header_; }
  /// Times of all frames [s].
  const std::vector<double>& times() const { return times_; }
  /// Index of the frame whose time is nearest to a time [s]. @pre there is a frame
  std::size_t nearest(double time) const;

  using Visitor = std::function<void(const results::Frame&)>;
  /// Reads frames one after another.
  /// @param first  index of the first one; first + count <= times().size()
  /// @throws storage::StorageError  the file cannot be read
  void visit(std::size_t first, std::size_t count, const Visitor& use) const;

private:
  void read_times_of_journal();
  void visit_journal(std::size_t first, std::size_t count, const Visitor& use) const;

  std::filesystem::path journal_;
  std::optional<results::ResultReader> results_;  ///< of a run that has ended
  results::RunHeader header_;
  std::vector<double> times_;
};

}  // namespace dccast::worker
