#pragma once

#include <string>
#include <vector>

#include "core/results/frame.hpp"

namespace dccast::results {

/// The sidecar with which ParaView opens a result file as a time series (XDMF 3, one dataset per
/// step: hyperslabs into one dataset are read as nothing by one of ParaView's two readers).
/// @param hdf5_name  name of the result file, which is in the same folder
std::string xdmf_of(const std::vector<FrameOutline>& frames, const std::string& hdf5_name);

/// What the sidecar has to know of a frame.
FrameOutline outline_of(const Frame& frame);

}  // namespace dccast::results
