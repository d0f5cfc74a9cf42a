#pragma once

#include "core/casting/check/case_findings.hpp"

namespace dccast::casting {

/// What the course of the casting in time follows from.
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
/// What the number of cells of the built-in mesh follows from, besides the course.
inline const Keys grid_keys = {"section.kind", "mesh.columns",        "mesh.layers",
                               "mesh.rows",    "mesh.growth_cell",    "mesh.refinement",
                               "mesh.element", "limits.maximum_nodes"};
/// What the plan of a quarter slab follows from.
inline const Keys plan_keys = {"section.half_width",  "section.half_thickness", "mesh.columns",
                               "mesh.layers",         "mesh.refinement",        "mesh.side_cell",
                               "mesh.wide_side_cell", "section.corner_radius"};
/// What the places of its nodes follow from, besides their number.
inline const Keys place_keys = {
    "section.half_width",  "section.half_thickness", "section.initial_depth", "mesh.side_cell",
    "mesh.wide_side_cell", "mesh.bottom_cell",       "section.corner_radius"};

// Each adds its faults; a file each. Those further down use what those above have found.

void check_alloy(CaseFindings& found);
void check_zones(CaseFindings& found);
/// Factors and shifts of the schedule, pulses of the water, faces with water of their own.
void check_levers(CaseFindings& found);
/// Abscissae that increase.
void check_tables(CaseFindings& found);
void check_section(CaseFindings& found);
/// The plan of a quarter slab, and what belongs to one alone.
void check_quarter_slab(CaseFindings& found);
/// Whether each break point of a quarter slab's opening has a row of nodes in its plan.
bool break_points_have_nodes(const mesh::SectionSpec& section);
/// The rounded corner of a quarter slab fits into its plan and its mesh.
void check_corner(CaseFindings& found);
/// A block that is not flat must touch the slab somewhere.
void check_block_profile(CaseFindings& found);
void check_time(CaseFindings& found);
void check_mechanics(CaseFindings& found);
/// Steps, and how high the metal ends.
void check_course(CaseFindings& found);
void check_built_in_size(CaseFindings& found);
void check_imported_mesh(CaseFindings& found);
void check_temperature_file(CaseFindings& found);
void check_monitors(CaseFindings& found);
void check_plausibility(CaseFindings& found);
/// Warns of a case that shows nothing.
void advise(CaseFindings& found);

/// Adds the fault of a mesh beyond limits.maximum_nodes. @param nodes  their number [1]
void too_many_nodes(CaseFindings& found, double nodes);

/// Seconds and memory, from nodes and steps; estimate_effort.cpp says how well.
void estimate_effort(CaseFindings& found);

}  // namespace dccast::casting
