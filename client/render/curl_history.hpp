#pragma once

#include <string>
#include <vector>

#include "dccast/v1/job.pb.h"

namespace dccast::client::render {

/// Curl of every monitor against time and cast length. Curl is the vertical displacement.
struct CurlHistory {
  struct Series {
    std::string name;
    std::vector<double> curl_m;        ///< one per instant; NaN where the monitor is not reported
    std::vector<double> horizontal_m;  ///< displacement away from the symmetry plane
  };
  std::vector<double> time_s;
  std::vector<double> cast_length_m;
  std::vector<Series> monitors;

  void add(const v1::StepReport& step);
  /// Forgets what comes after this time: the run went on from a checkpoint.
  void rewind(double time_s);
  /// The monitor whose curl is largest now; null before the first step.
  const Series* largest() const;
};

/// Curl of a monitor [m]; NaN if it has no vertical displacement.
double curl_of(const v1::MonitorValue& monitor);

}  // namespace dccast::client::render
