#pragma once

#include <optional>

#include "dccast/v1/case.pb.h"

/// What `quality` picks: the mesh and the time steps that a case leaves open. The one place of
/// these defaults; docs/error-bars.md has the measurements behind them.
namespace dccast::case_file {

/// Fills the keys of `mesh` and `time.step` that are absent, by quality and kind of section. Cells
/// have sizes, so that a wide section gets more of them; columns are uniform unless
/// `mesh.side_cell` is given. Explicit keys win. Changes nothing that needs a size of the section
/// which is absent or not positive.
void apply_quality(v1::Case& description);

/// Half the width of the band of docs/error-bars.md, relative to the curl at the end [1]: what mesh
/// and time steps leave uncertain. Nothing where no band was measured: of other sections than one
/// in plane strain through the thickness of a slab (half width 0.2 to 0.4 m), of meshes and steps
/// that differ from those of the quality, of files.
/// @param complete  with all its defaults
std::optional<double> relative_discretisation_error(const v1::Case& complete);

}  // namespace dccast::case_file
