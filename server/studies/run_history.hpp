#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/study.pb.h"

namespace dccast::studies {

/// The curl of one run: the vertical displacement of every monitor.
struct RunHistory {
  std::vector<v1::CurlCurve> curves;    ///< by monitor, all at the instants of the run's steps
  std::optional<double> beyond_from_s;  ///< first step at which the model was no longer valid

  /// [degC] by monitor, at the same instants; NaN where it is not reported.
  std::map<std::string, std::vector<double>> temperature_c;

  const v1::CurlCurve* curve(const std::string& monitor) const;  ///< null: not reported
};

/// The history in the steps of a job.
RunHistory run_history(const v1::Job& job, const std::vector<v1::StepReport>& steps);

/// Curl of a monitor [m]: its displacement along the last coordinate; NaN when there is none.
double curl_of(const v1::MonitorValue& monitor);

/// Curl of a monitor in a step [m]; NaN when it is not reported there.
double curl_at(const v1::StepReport& step, const std::string& monitor);

}  // namespace dccast::studies
