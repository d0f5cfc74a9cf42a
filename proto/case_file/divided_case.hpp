#pragma once

#include <string>

#include "dccast/v1/case.pb.h"

namespace dccast::case_file {

/// The case with every cell and every time step divided. The smallest permitted step is divided
/// too, so that a step can be reduced as often as before.
v1::Case divided(const v1::Case& description, int parts);

/// Why the cells of a case cannot be divided or its results cannot be compared; empty if they can.
std::string reason_against_dividing(const v1::Case& description);

/// Whether two cases, with all their defaults, are the same casting on meshes and steps divided by
/// their mesh.refinement. Keys that do not affect the results (title, output, checkpoints, limits)
/// may differ.
bool is_refined_case(const v1::Case& a, const v1::Case& b);

}  // namespace dccast::case_file
