#pragma once

#include <vector>

#include "core/results/finding.hpp"

namespace dccast::results {

namespace hdf5 {
class File;
}

/// The group /findings of SCHEMA.md. Nothing is written without findings, and none are read where
/// it is absent. Both may throw StorageError.
void write_findings(hdf5::File& file, const std::vector<Finding>& findings);
std::vector<Finding> read_findings(const hdf5::File& file);

}  // namespace dccast::results
