#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/session/connection.hpp"
#include "dccast/v1/study.pb.h"
#include "proto/frames/contraction.hpp"

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

/// The mould of one run and the resulting cold slab.
struct CastMould {
  v1::Section section;
  frames::SteadyFace face;
};

/// One run of a mould design.
struct MouldRun {
  std::string job;  ///< empty until it is queued
  v1::JobState state = v1::JOB_STATE_UNSPECIFIED;
  std::optional<CastMould> cast;  ///< set if the run succeeded
  std::string reason;             ///< why the run failed or its results cannot be read
};

/// A study that searches for the opening of a mould, with the results of its runs.
struct MouldDesign {
  v1::StudyResult result;
  double wanted_m = 0.0;  ///< wanted half-thickness of the cold slab [m]
  std::vector<MouldRun> runs;

  const v1::StudyResult::MouldFound& found() const { return result.mould(); }
  /// Whether the face of the best run has stopped changing along the slab, within the tolerance: a
  /// face that has not may contract further.
  bool steady() const;
  /// The run with the opening that was found; null if there is none yet.
  const MouldRun* best() const;
};

/// Throws CommandFailed, also for a study of another kind.
MouldDesign read_mould_design(Connection& connection, const std::string& study);

/// What the user chose, with the limits of a plant. Texts are as in a case file.
struct RecipeChoice {
  std::string band;   ///< empty: plausibility.least_curl and greatest_curl of the case
  std::string point;  ///< empty: the monitor with the largest curl
  std::string speed = "20..120 mm/min", speed_rate = "60 mm/min2";
  std::string water = "30..400 l/min/m", water_rate = "200 l/min2/m";
  std::string hold = "10..300 s", filling = "5..200 s", ramp = "10..600 s";
  int within_percent = 30;  ///< levels of speed and water about those of the case
  int drafts = 128, castings = 12, candidates = 4;
  std::uint64_t seed = 0;
};

/// Makes the study of a request a recipe plan, with every datum that has a range. Levels may be
/// `within_percent` of the case's, times between half and double; all of it inside the limits. The
/// request id follows from the request, so that the same one finds the study that is there. Throws
/// CommandFailed.
void lay_out_recipe(Connection& connection, const RecipeChoice& choice,
                    v1::CreateStudyRequest& request);

/// Goes on with a study that was cancelled or lost runs to their machine. @return as it is then
v1::Study taken_up(Connection& connection, const v1::Study& study);

/// Cancels a study after an interruption, over a connection of its own.
void cancel_after_interruption(const Connection& interrupted, const std::string& id);

}  // namespace dccast::client
