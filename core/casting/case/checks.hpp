#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "core/casting/case/case_check.hpp"
#include "core/mesh/base.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::casting {

using Keys = std::vector<std::string>;

inline constexpr double length_round_off = 1e-9;  ///< [m] lengths that differ by less are equal

/// A value with its unit: "0.28 m". @param value  [`unit`]
std::string with_unit(double value, const char* unit);

/// A case during its check: the faults found so far and intermediate results for later checks. A
/// check that depends on a faulty key is skipped and reported as skipped, see sound().
class CaseFindings {
public:
  CaseFindings(const Case& the_case, const std::vector<std::string>& faulty_keys)
      : casting(the_case), faulty_keys_(faulty_keys) {}

  /// Adds a fault, see Faults::add().
  template <class... Rest>
  void fault(Rest&&... rest) {
    faults.add(std::forward<Rest>(rest)...);
  }
  /// Adds a warning, see Faults::add().
  template <class... Rest>
  void warning(Rest&&... rest) {
    warnings_.add(std::forward<Rest>(rest)...);
  }

  /// The fault that makes the value of a key unusable; empty if there is none.
  std::string fault_of(std::string_view key) const;
  /// Whether none of these keys has a fault, so that checks depending on them are meaningful. If
  /// not, the answer names the fault they wait for.
  bool sound(const Keys& keys);
  bool axisymmetric() const { return casting.section.kind == mesh::SectionKind::axisymmetric; }
  bool solid() const { return mesh::dimension_of(casting.section.kind) == 3; }
  /// The plan of the heat that is built in, made once. @pre plan_keys are sound
  const mesh::Base<3>& built_in_plan();

  /// All findings, with warnings for the checks that were skipped.
  CheckedCase answer();

  /// The case under check, and what was found so far.
  const Case& casting;
  Faults faults;
  Estimate estimate;
  /// [m] metal level at the end; set if `course_keys` are sound
  std::optional<double> final_level;
  std::int64_t mechanical_steps = 0;  ///< of the estimate's steps
  /// The mesh of the section's dimension, set if mesh.file is sound.
  std::tuple<std::optional<mesh::Mesh2D>, std::optional<mesh::Mesh3D>> imported;
  /// The plan of a plan file as it is drawn, without refinement; set if mesh.file is sound.
  std::optional<mesh::Base<3>> plan;
  std::int64_t nodes_per_row = 0;  ///< of a mesh of rows, where the results are

private:
  const std::vector<std::string>& faulty_keys_;
  Faults warnings_;
  std::set<std::string> waited_for_;
  std::optional<mesh::Base<3>> built_in_plan_;
};

/// Keys that determine the course of the casting in time.
inline const Keys course_keys = {"time.end",
                                 "time.step",
                                 "schedule.hold",
                                 "schedule.casting_speed",
                                 "schedule.casting_speed_factor",
                                 "schedule.casting_speed_shift",
                                 "cooling.water.start",
                                 "cooling.water.pulse_period",
                                 "cooling.narrow_water.start",
                                 "cooling.second_water.start",
                                 "cooling.narrow_water.pulse_period",
                                 "mechanics.start",
                                 "section.initial_depth",
                                 "mesh.growth",
                                 "output.frame_interval",
                                 "limits.maximum_steps"};
/// Keys that determine the plan of a quarter slab.
inline const Keys plan_keys = {"section.half_width",
                               "section.half_thickness",
                               "mesh.columns",
                               "mesh.layers",
                               "mesh.refinement",
                               "mesh.side_cell",
                               "mesh.wide_side_cell",
                               "section.corner_radius",
                               "mesh.heat_cells_per_column",
                               "mesh.heat_cells_per_layer"};

// Each check adds its faults. Later checks use the results of earlier ones.

/// Ranges of the card: path of solidification, tables, coherency.
void check_alloy(CaseFindings& found);
/// Zones must not overlap on one face, and must lie on the side.
void check_zones(CaseFindings& found);
/// Factors and shifts of the schedule, pulses of the water, faces with water of their own.
void check_levers(CaseFindings& found);
/// Abscissae of tables must increase.
void check_tables(CaseFindings& found);
/// Nodes in a row of the built-in mesh against `limits`, before any plan is built.
void check_row_size(CaseFindings& found);
/// Size of the section against its mesh.
void check_section(CaseFindings& found);
/// The plan of a quarter slab, and keys that apply to quarter slabs only.
void check_quarter_slab(CaseFindings& found);
/// Reports a key that applies to quarter slabs only.
void quarter_slab_only(CaseFindings& found, const char* key, bool given);
/// Water under the butt follows one law, and boils as that of the faces.
void check_gap_water(CaseFindings& found);
/// A bowl must fit into the block, and its wall must be at least as wide as it is deep.
void check_bowl(CaseFindings& found);
/// Drain holes lie in the block of a quarter slab, and let out the water that gap_water lets in.
void check_drain_holes(CaseFindings& found);
/// A block with a gap at the start must touch the slab somewhere.
void check_block_profile(CaseFindings& found);
/// End and steps against the times of the schedule.
void check_time(CaseFindings& found);
/// Options of algorithms against their conditions of convergence and validity.
void check_mechanics(CaseFindings& found);
/// Number of steps and the final metal level.
void check_course(CaseFindings& found);
/// Nodes of the built-in mesh at the end against `limits`.
void check_built_in_size(CaseFindings& found);
/// A plan from a file: readable, in metres, as large as the section, and its nodes at the end.
void check_plan_file(CaseFindings& found);
/// An imported mesh: readable, in metres, with the patches that the case needs.
void check_imported_mesh(CaseFindings& found);
/// Prescribed temperatures: readable, and as many as the mesh has nodes.
void check_temperature_file(CaseFindings& found);
/// Monitors must lie in the slab, or be means of such, with names of their own.
void check_monitors(CaseFindings& found);
/// Limits of the findings among each other.
void check_plausibility(CaseFindings& found);
/// Warns of a case whose results would show nothing of interest.
void advise(CaseFindings& found);

/// Estimates computing time and memory from nodes and steps; estimate_effort.cpp states the
/// accuracy.
void estimate_effort(CaseFindings& found);

}  // namespace dccast::casting
