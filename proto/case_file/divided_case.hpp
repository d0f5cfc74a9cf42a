#pragma once

#include <string>

#include "dccast/v1/case.pb.h"

namespace dccast::case_file {

/// The case with every cell and every time step divided. The shortest step permitted is divided
/// too, so that a step may be cut as often as before.
v1::Case divided(const v1::Case& description, int parts);

/// Why the cells of a case cannot be divided, or nothing is there to compare; empty when they can.
std::string reason_against_dividing(const v1::Case& description);

/// Whether two cases, with all their defaults, are one casting on meshes and steps divided by their
/// mesh.refinement. What does not bear on the figures (title, output, checkpoints, limits) may
/// differ.
bool is_refined_case(const v1::Case& a, const v1::Case& b);

}  // namespace dccast::case_file
