#pragma once

#include <vector>

#include "core/results/finding.hpp"

namespace dccast::hdf5 {
class File;
}

namespace dccast::results {

/// Writes and reads the group /findings of SCHEMA.md. The group exists only if there are findings.
/// Both functions may throw storage::StorageError.
void write_findings(hdf5::File& file, const std::vector<Finding>& findings);
std::vector<Finding> read_findings(const hdf5::File& file);

}  // namespace dccast::results
