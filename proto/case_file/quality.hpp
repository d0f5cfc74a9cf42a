#pragma once

#include <optional>

#include "dccast/v1/case.pb.h"

/// Defaults of mesh and time steps by `quality`, defined here only; docs/error-bars.md has the
/// measurements on which they are based.
namespace dccast::case_file {

/// Fills missing keys of `mesh` and `time.step` according to quality and kind of section. Qualities
/// define cell sizes, so that a wide section gets more cells; columns are uniform unless
/// `mesh.side_cell` is given. Explicit keys take precedence. Keys that depend on a missing or
/// non-positive size of the section are not filled.
void apply_quality(v1::Case& description);

/// Uncertainty of the final curl due to mesh and time steps: half the width of the band of
/// docs/error-bars.md, relative to the curl [1]. Empty if no band was measured: it exists, with the
/// built-in mesh and steps of the quality, for plane-strain thickness sections (half width 0.2 to
/// 0.4 m) and for the first 300 s of quarter slabs (half width 0.5 to 0.9 m, half thickness 0.2 to
/// 0.4 m).
/// @param complete  case with all its defaults
std::optional<double> relative_discretisation_error(const v1::Case& complete);

}  // namespace dccast::case_file
