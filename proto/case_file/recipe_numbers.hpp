#pragma once

#include <array>
#include <string>
#include <vector>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/job.pb.h"

/// The recipe of a start as a few numbers: speed and water ramp from one level to another, metal is
/// filled in and held before the block starts. docs/recipe.md.
namespace dccast::case_file {

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

inline constexpr std::array<const char*, recipe_size> recipe_names{
    "speed_start", "speed_run",   "speed_ramp", "filling",
    "hold",        "water_start", "water_run",  "water_ramp"};

/// Speeds [m/s], water [m2/s], filling and hold [s], by RecipeNumber. A ramp is as long as its
/// table is: [s], or [m] where that stands against cast length.
using Recipe = std::array<double, recipe_size>;

/// The recipe of a complete case: first and last value of its tables, and the distance between
/// those points; a single value is both, with a ramp of 60 s.
Recipe recipe_of(const v1::Case& complete);

/// Whether the ramp of a table has a cast length.
bool ramps_by_length(const v1::Curve& curve);

/// What turns a complete case into one with another recipe that casts the same length: tables of
/// speed and water that begin to ramp where those of the case do, filling, hold, and the end of the
/// time. Numbers have four digits. What does not differ is not in it.
std::vector<v1::CaseChange> recipe_changes(const v1::Case& complete, const Recipe& recipe);

/// Cast length at the end of a complete case [m].
double cast_length_at_end(const v1::Case& complete);

/// Time at which a complete case has cast a length [s]; infinite where it never does.
double time_of_cast_length(const v1::Case& complete, double length_m);

}  // namespace dccast::case_file
