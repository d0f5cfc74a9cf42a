#pragma once

#include <cmath>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/job.pb.h"

/// Defaults of mesh and time steps by `quality`, defined here only;
/// docs/developers/discretisation.md has the measurements on which they are based.
namespace dccast::case_file {

/// Fills missing keys of `mesh` and `time.step` according to quality and kind of section. Qualities
/// define cell sizes, so that a wide section gets more cells; columns are uniform unless
/// `mesh.side_cell` is given. The heat of a quarter slab divides these cells, unless the case gives
/// its own columns or layers. Explicit keys take precedence. Keys that depend on a missing or
/// non-positive size of the section are not filled.
void apply_quality(v1::Case& description);

/// Whether mesh or time steps depend on the quality. They do not if the case gives all of them.
/// @param description  case as submitted
bool quality_matters(const v1::Case& description);

/// How far mesh and time steps may have put the true curl below and above the computed one,
/// relative to the computed one [1]: the band of docs/error-bars.md. Empty if no band was measured:
/// it exists, with the built-in mesh and steps of the quality, for plane-strain thickness sections
/// (half width 0.2 to 0.4 m) and for the first 1200 s of quarter slabs (half width 0.5 to 1.1 m,
/// half thickness 0.2 to 0.4 m), at the monitors of is_measured_at().
/// @param complete  case with all its defaults
std::optional<v1::RelativeError> relative_discretisation_error(const v1::Case& complete);

/// How far mesh and time steps may have put a true figure that findings judge below and above the
/// computed one: docs/error-bars.md.
struct FigureBand {
  const char* figure;               ///< name, as in core/casting/findings/rules_of_step.cpp
  double below = 0.0, above = 0.0;  ///< in SI units or degC, or relative to the figure [1]
  bool is_relative = false;
};

/// The bands of the figures; none where none were measured: they exist for the quarter slabs of
/// relative_discretisation_error(). @param complete  case with all its defaults
std::vector<FigureBand> figure_bands(const v1::Case& complete);

/// Whether the bands were measured at a monitor: in a section at any, in a quarter slab along the
/// narrow edge of the butt, from its middle to the corner; and at a mean of such monitors.
bool is_measured_at(const v1::Case& description, const std::string& monitor);

/// The band of a monitor; empty where it was not measured.
/// @param complete  case with all its defaults
std::optional<v1::RelativeError> monitor_error(const v1::Case& complete,
                                               const std::string& monitor);

/// How far the true curl may lie below and above a computed one [m].
struct CurlError {
  double lower_m = 0.0;
  double upper_m = 0.0;
  double larger_m() const { return lower_m > upper_m ? lower_m : upper_m; }
};

/// The errors of a curl. Below zero "more" is further down, so they change sides.
/// @param curl_m  [m]
CurlError curl_error(const v1::RelativeError& error, double curl_m);

/// Sets the errors of curls at the end [m] of a run of a study or of a prediction, which has those
/// relative to them; none where they are not known, NaN at a monitor where they were not measured.
/// @param curls_m  (monitor of the case)
template <class Curls, class Message>
void set_end_errors(const v1::Case& description, const Curls& curls_m, Message& message) {
  if (!message.has_mesh_error()) return;
  for (int i = 0; i < int(std::size(curls_m)); ++i) {
    const std::string name = i < description.monitor_size() ? description.monitor(i).name() : "";
    const CurlError error =
        curl_error(message.mesh_error(),
                   is_measured_at(description, name) ? curls_m[std::size_t(i)] : std::nan(""));
    message.add_end_lower_error_m(error.lower_m);
    message.add_end_upper_error_m(error.upper_m);
  }
}

/// Adds curl and errors to a monitor that has its displacement: its last coordinate, if it has
/// several and metal has reached it. Every curl of a run is made here.
/// @param mesh_error  empty: not known
void add_curl(const std::optional<v1::RelativeError>& mesh_error, v1::MonitorValue& monitor);

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

/// The case with every cell and every time step divided. The smallest permitted step is divided
/// too, so that a step can be reduced as often as before.
v1::Case divided(const v1::Case& description, int parts);

/// The reason why the cells of a case cannot be divided or its results cannot be compared; empty if
/// they can.
std::string reason_against_dividing(const v1::Case& description);

}  // namespace dccast::case_file
