#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "client/session/failure.hpp"
#include "dccast/v1/study.pb.h"

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

}  // namespace dccast::client
