#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/study.pb.h"

namespace dccast::client {

/// What one axis of a sensitivity study does to the curl of a monitor at the end.
struct Effect {
  int axis = 0;
  std::optional<double> low_m, high_m;    ///< difference to the case itself; empty: no valid run
  std::string low_failure, high_failure;  ///< why
  double largest_m() const;               ///< of the amounts
};

/// The effects of a study, largest first.
struct Effects {
  std::optional<double> base_m;  ///< curl of the case itself; empty: no valid run
  std::vector<Effect> effects;
  std::optional<double> error_m;  ///< to which a small difference of two runs is known
};
/// @param of_curl  share of a curl that is the error of a small difference
///                 (case_file::paired_error); empty: not known
Effects effects_of(const v1::StudyResult& result, int monitor, std::optional<double> of_curl);

/// Index of the monitor with this name; with an empty name that with the largest curl at the end.
/// @return -1 where there is none
int monitor_of(const v1::StudyResult& result, const std::string& name);

/// "± 10 %", "± 3 K", "20..30 degC", "0.5..2 times" of an axis with two ends.
std::string range_of(const v1::SweepPlan::Axis& axis);

/// A number with its unit in four digits: "231.5 degC". @param text  as in a case file
std::string rounded(const std::string& text);

/// The number that a text begins with; 0 if it begins with none.
double leading_number(const std::string& text);

/// How the runs of a study ended, "61 valid, 2 beyond validity, 1 failed".
struct RunCount {
  int valid = 0, beyond = 0, failed = 0, open = 0;
  std::string text() const;
};
RunCount count_runs(const v1::StudyResult& result);

}  // namespace dccast::client
