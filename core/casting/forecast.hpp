#pragma once

#include <vector>

#include "core/casting/case/case.hpp"
#include "core/results/step_report.hpp"

namespace dccast::casting {

/// A forecast of the findings, before the case is run: those of a heat-only run on a coarse mesh
/// with few steps, which takes milliseconds. A quarter slab is represented by its thickness
/// section. Empty for an imported mesh or temperatures from a file.
std::vector<results::Finding> forecast(const Case& casting_case);

}  // namespace dccast::casting
