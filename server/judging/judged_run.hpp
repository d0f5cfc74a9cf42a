#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/job.pb.h"

namespace dccast::judging {

/// A run as it is judged: its case with all defaults, and its accepted steps, each once.
struct JudgedRun {
  std::string name;  ///< under which it is shown
  v1::Case description;
  std::vector<v1::StepReport> steps;  ///< by time

  std::vector<double> time_s() const;         ///< (step) [s]
  std::vector<double> cast_length_m() const;  ///< (step) [m]
  /// Monitors with a reported curl, in the order in which they were first reported.
  std::vector<std::string> monitors() const;
  /// Vertical displacement of a monitor (step) [m]; NaN where it is not reported. Empty for a
  /// monitor that is never reported.
  std::vector<double> curl_m(const std::string& monitor) const;
};

}  // namespace dccast::judging
