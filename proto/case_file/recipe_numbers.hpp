#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/job.pb.h"

/// The recipe of a start as a few numbers: speed and water ramp from one level to another, metal is
/// filled in and held before the block starts. docs/recipe.md.
namespace dccast::case_file {

/// The numbers of a recipe.
enum RecipeNumber {
  speed_start,
  speed_run,
  speed_ramp,
  filling,
  hold,
  water_start,
  water_run,
  water_ramp,
  recipe_size
};

/// Names of the numbers in requests and results.
inline constexpr std::array<const char*, recipe_size> recipe_names{
    "speed_start", "speed_run",   "speed_ramp", "filling",
    "hold",        "water_start", "water_run",  "water_ramp"};

/// (RecipeNumber) speeds [m/s], water [m2/s], filling and hold [s]; lengths of ramps in the unit of
/// the abscissa of the table: [s], or [m] against cast length.
using Recipe = std::array<double, recipe_size>;

/// The recipe of a complete case: first and last value of its tables, and the distance between
/// those points; a single value is both, with a ramp of 60 s.
Recipe recipe_of(const v1::Case& complete);

/// Changes that give a complete case another recipe and the same final cast length: tables of speed
/// and water whose ramps begin where those of the case do, filling, hold, and time.end. Numbers
/// have four digits. Keys that do not differ are left out.
std::vector<v1::CaseChange> recipe_changes(const v1::Case& complete, const Recipe& recipe);

/// The change of time.end with which a changed case casts the length of the case itself, to a tenth
/// of a second; empty: it does so already, or never.
/// @param changed, complete  with all defaults
std::optional<v1::CaseChange> end_at_same_length(const v1::Case& changed, const v1::Case& complete);

}  // namespace dccast::case_file
