#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/session/connection.hpp"
#include "dccast/v1/study.pb.h"

/// Plans of studies: sweeps, the design of a mould, and of a recipe.
namespace dccast::client {

/// Content of a sweep file: its case and its plan.
///
///     case = "start-2d-thickness.toml"   # beside the sweep file
///     design = "latin_hypercube"         # grid, list
///     runs = 40                          # of a Latin hypercube
///     seed = 1
///     [[axis]]
///     key = "schedule.casting_speed"
///     values = ["40 mm/min", "80 mm/min"]
struct SweepFile {
  std::string case_file;  ///< path relative to the working directory
  v1::SweepPlan plan;
};

/// Whether a file is a sweep, and not a case.
bool is_sweep_file(const std::string& file);

/// Throws CommandFailed.
SweepFile read_sweep_file(const std::string& file);

/// An axis from "KEY=a,b,c". Commas inside brackets and quotes do not separate values. Throws
/// CommandFailed.
v1::SweepPlan::Axis axis_of(std::string_view text);

/// What the user chose, with the limits of a plant. Texts are as in a case file.
struct RecipeChoice {
  std::string band;   ///< empty: plausibility.least_curl and greatest_curl of the case
  std::string point;  ///< empty: output.curl, or the largest
  std::string line;   ///< whose castings condition the data; empty: none
  std::string speed = "20..120 mm/min", speed_rate = "60 mm/min2";
  /// Limits of the plant, as options give them.
  std::string water = "30..400 l/min/m", water_rate = "200 l/min2/m";
  std::string hold = "10..300 s", filling = "5..200 s", ramp = "10..600 s";
  int within_percent = 30;  ///< levels of speed and water about those of the case
  int drafts = 128, castings = 12, candidates = 4;
  /// The same seed gives the same Latin hypercubes.
  std::uint64_t seed = 0;
};

/// Makes the study of a request a recipe plan, with every datum that has a range. Levels may be
/// `within_percent` of the case's, times between half and double; all of it inside the limits. The
/// same plan finds the study that is there. Throws CommandFailed.
void lay_out_recipe(Connection& connection, const RecipeChoice& choice,
                    v1::CreateStudyRequest& request);

/// The study of what helps against the findings of a job, created or found: a user has one for each
/// job. @param line  whose castings condition the data of its drafts; empty: none
/// @throws CommandFailed  it has not ended, or no lever influences its findings
v1::Study remedy_of(Connection& connection, const std::string& job, const std::string& line = {});

/// Goes on with a study that was cancelled or lost runs to their machine. @return as it is then
v1::Study taken_up(Connection& connection, const v1::Study& study);

/// Cancels a study after an interruption, over a connection of its own.
void cancel_after_interruption(const Connection& interrupted, const std::string& id);

}  // namespace dccast::client
