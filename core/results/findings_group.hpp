#pragma once

#include <vector>

#include "core/results/step_report.hpp"

namespace dccast::results::hdf5 {
class File;
}

namespace dccast::results {

/// Writes the group /findings of SCHEMA.md, if there are findings. @throws storage::StorageError
void write_findings(hdf5::File& file, const std::vector<Finding>& findings);
/// Reads the group /findings; empty if the file has none.
/// @throws storage::StorageError  also if a severity is unknown or a column has the wrong length
std::vector<Finding> read_findings(const hdf5::File& file);

/// Writes the group /margins of SCHEMA.md, if there are margins. @throws storage::StorageError
void write_margins(hdf5::File& file, const std::vector<Margin>& margins);

}  // namespace dccast::results
