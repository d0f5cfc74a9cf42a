#pragma once

#include <vector>

#include "core/results/finding.hpp"

namespace dccast::hdf5 {
class File;
}

namespace dccast::results {

/// The group /findings of SCHEMA.md. Nothing is written without findings, and none are read where
/// it is absent. Both may throw storage::StorageError.
void write_findings(hdf5::File& file, const std::vector<Finding>& findings);
std::vector<Finding> read_findings(const hdf5::File& file);

}  // namespace dccast::results
