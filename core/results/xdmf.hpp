#pragma once

#include <string>
#include <vector>

#include "core/results/frame.hpp"

namespace dccast::results {

/// The sidecar with which ParaView opens a result file as a time series (XDMF 3). There is one
/// dataset per frame, because one of ParaView's two XDMF readers does not read hyperslabs of a
/// common dataset.
/// @param hdf5_name  name of the result file, which is in the same folder
std::string xdmf_of(const std::vector<FrameOutline>& frames, const std::string& hdf5_name);

/// The outline of a frame for the sidecar.
FrameOutline outline_of(const Frame& frame);

}  // namespace dccast::results
