#pragma once

#include <optional>
#include <string>

#include "dccast/v1/case.pb.h"

/// Defaults of mesh and time steps by `quality`, defined here only;
/// docs/developers/discretisation.md has the measurements on which they are based.
namespace dccast::case_file {

/// Fills missing keys of `mesh` and `time.step` according to quality and kind of section. Qualities
/// define cell sizes, so that a wide section gets more cells; columns are uniform unless
/// `mesh.side_cell` is given. Explicit keys take precedence. Keys that depend on a missing or
/// non-positive size of the section are not filled.
void apply_quality(v1::Case& description);

/// Whether mesh or time steps depend on the quality. They do not if the case gives all of them.
/// @param description  case as submitted
bool quality_matters(const v1::Case& description);

/// Uncertainty of the final curl due to mesh and time steps: half the width of the band of
/// docs/error-bars.md, relative to the curl [1]. Empty if no band was measured: it exists, with the
/// built-in mesh and steps of the quality, for plane-strain thickness sections (half width 0.2 to
/// 0.4 m) and for the first 300 s of quarter slabs (half width 0.5 to 0.9 m, half thickness 0.2 to
/// 0.4 m).
/// @param complete  case with all its defaults
std::optional<double> relative_discretisation_error(const v1::Case& complete);

/// Discretisation error of the difference of two curls: a share of the larger curl and a share of
/// the difference.
struct PairedError {
  double of_curl;        ///< [1]
  double of_difference;  ///< [1]
};
/// That of two quarter slabs.
inline constexpr PairedError quarter_slab_pairs{.of_curl = 0.05, .of_difference = 0.2};

/// The error of a difference between two castings of the same quality, from pairs that were
/// computed at two qualities (docs/error-bars.md). Empty where no pairs were measured: it exists
/// for quarter slabs and for the sections of relative_discretisation_error().
/// @param a, b  cases with all their defaults
std::optional<PairedError> paired_error(const v1::Case& a, const v1::Case& b);

/// Whether two cases, with all their defaults, differ in mesh, time steps and quality only. Keys
/// that do not affect the results may differ.
bool is_same_casting(const v1::Case& a, const v1::Case& b);

/// The case with every cell and every time step divided. The smallest permitted step is divided
/// too, so that a step can be reduced as often as before.
v1::Case divided(const v1::Case& description, int parts);

/// The reason why the cells of a case cannot be divided or its results cannot be compared; empty if
/// they can.
std::string reason_against_dividing(const v1::Case& description);

}  // namespace dccast::case_file
