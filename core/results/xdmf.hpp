#pragma once

#include <filesystem>
#include <string>

namespace dccast::results {

/// Writes the sidecar with which ParaView opens a result file as a time series (XDMF 3, one dataset
/// per step: hyperslabs into one dataset are read as nothing by one of ParaView's two readers).
/// @param sidecar    appears whole or not at all
/// @param results    a finished result file, for the sizes
/// @param hdf5_name  name of the result file as the sidecar refers to it, relative to itself
/// @throws StorageError
void write_xdmf(const std::filesystem::path& sidecar, const std::filesystem::path& results,
                const std::string& hdf5_name);

}  // namespace dccast::results
