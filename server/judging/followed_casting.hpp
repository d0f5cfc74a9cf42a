#pragma once

#include <string>
#include <vector>

#include "dccast/v1/follow.pb.h"
#include "dccast/v1/judgement.pb.h"
#include "server/judging/judged_run.hpp"
#include "server/levers/lever_watch.hpp"

namespace dccast::judging {

/// What a gauge was expected to show, as of a fixed time before. All arrays are by reading;
/// readings that were left out are not there.
struct PastForecast {
  std::string monitor;
  double ahead_s = 0.0;
  std::vector<double> time_s{};
  std::vector<double> measured_m{};
  std::vector<double> expected_m{};
  std::vector<double> lower_m{}, upper_m{};  ///< the band of nine in ten, noise and zero included
};

/// What a casting that was followed has measured, and what was forecast of it.
struct FollowedCasting {
  v1::Forecast forecast{};           ///< after the last reading
  std::vector<PastForecast> past{};  ///< of each gauge 30 and 60 s ahead
  std::string no_forecast{};         ///< why there is none; empty: there is one
  std::vector<levers::PouredLever> poured{};
  bool has_findings = false;  ///< beyond notes
};

/// Adds the table "poured" with the levers as they were measured, and a chart "forecast" for each
/// gauge: measured, computed, and what had been forecast 60 s before each time. Then the table
/// "forecast" with the errors by time ahead, and the table "warnings". Without a forecast the table
/// "forecast" has the reason as its note.
void add_followed(const FollowedCasting& followed, const JudgedRun& run, v1::Judgement& judgement);

}  // namespace dccast::judging
