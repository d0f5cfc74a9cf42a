#pragma once

#include "core/case/check/case_findings.hpp"

namespace dccast::casting {

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
                                 "cooling.narrow_water.pulse_period",
                                 "mechanics.start",
                                 "section.initial_depth",
                                 "mesh.growth",
                                 "limits.maximum_steps"};
/// Keys that determine the number of cells of the built-in mesh, besides course_keys.
inline const Keys grid_keys = {"section.kind", "mesh.columns",        "mesh.layers",
                               "mesh.rows",    "mesh.growth_cell",    "mesh.refinement",
                               "mesh.element", "limits.maximum_nodes"};
/// Keys that determine the plan of a quarter slab.
inline const Keys plan_keys = {"section.half_width",  "section.half_thickness", "mesh.columns",
                               "mesh.layers",         "mesh.refinement",        "mesh.side_cell",
                               "mesh.wide_side_cell", "section.corner_radius"};
/// Keys that determine the positions of its nodes, besides their number.
inline const Keys place_keys = {
    "section.half_width",  "section.half_thickness", "section.initial_depth", "mesh.side_cell",
    "mesh.wide_side_cell", "mesh.bottom_cell",       "section.corner_radius"};

// Each check adds its faults and has a file of its own. Later checks use the results of earlier
// ones.

void check_alloy(CaseFindings& found);
void check_zones(CaseFindings& found);
/// Factors and shifts of the schedule, pulses of the water, faces with water of their own.
void check_levers(CaseFindings& found);
/// Abscissae of tables must increase.
void check_tables(CaseFindings& found);
void check_section(CaseFindings& found);
/// The plan of a quarter slab, and keys that apply to quarter slabs only.
void check_quarter_slab(CaseFindings& found);
/// Whether each break point of a quarter slab's opening has a row of nodes in its plan.
bool break_points_have_nodes(const mesh::SectionSpec& section);
/// The rounded corner of a quarter slab must fit its plan and its mesh.
void check_corner(CaseFindings& found);
/// A block that is not flat must touch the slab somewhere.
void check_block_profile(CaseFindings& found);
void check_time(CaseFindings& found);
void check_mechanics(CaseFindings& found);
/// Number of steps and the final metal level.
void check_course(CaseFindings& found);
void check_built_in_size(CaseFindings& found);
void check_imported_mesh(CaseFindings& found);
void check_temperature_file(CaseFindings& found);
void check_monitors(CaseFindings& found);
void check_plausibility(CaseFindings& found);
/// Warns of a case whose results would show nothing of interest.
void advise(CaseFindings& found);

/// Adds the fault of a mesh beyond limits.maximum_nodes. @param nodes  their number [1]
void too_many_nodes(CaseFindings& found, double nodes);

/// Estimates computing time and memory from nodes and steps; estimate_effort.cpp states the
/// accuracy.
void estimate_effort(CaseFindings& found);

}  // namespace dccast::casting
