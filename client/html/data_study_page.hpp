#pragma once

#include <optional>
#include <string>

#include "dccast/v1/study.pb.h"

namespace dccast::client::render {

/// An uncertainty study as a page: the band of the data, that of mesh and time steps apart, the
/// shares of the data against time, and the runs that do not count.
/// @param mesh_error  half the band of mesh and steps relative to the curl; empty: not known
std::string uncertainty_page(const v1::StudyResult& result, std::optional<double> mesh_error);

/// A sensitivity study as a page: a bar for every lever and datum.
/// @param of_curl  as for effects_of()
std::string sensitivity_page(const v1::StudyResult& result, int monitor,
                             std::optional<double> of_curl);

/// A calibration as a page: what was measured over what is computed, with the bands of the data
/// before and after and that of mesh and time steps, keys and curves as tables, and the runs that
/// do not count.
std::string calibration_page(const v1::StudyResult& result);

}  // namespace dccast::client::render
