#pragma once

#include <optional>
#include <string>

#include "client/html/svg_chart.hpp"
#include "client/model/study.hpp"

namespace dccast::client::render {

/// Error of the curl of one run according to a study.
struct CurlError {
  double this_run_m = 0.0;  ///< distance to the limit plus the uncertainty of the limit [m]
  double limit_m = 0.0;
  double uncertainty_m = 0.0;  ///< of the limit [m]
  bool extrapolated = false;   ///< else the limit is the curl of the finest run
};

/// @return empty if the study has no result for this monitor at this time
std::optional<CurlError> curl_error(const Study& study, const std::string& monitor, double time_s,
                                    double curl_m);

/// Limit and interval of a monitor [mm] against time [s] or cast length [mm], thinned to the
/// resolution of a chart. Thinning may widen the interval but never narrows it.
ChartBand curl_band(const Study& study, const std::string& monitor, bool against_length);

/// The card "How much of it is discretisation" of a job's report, or a line with the
/// command that computes it where no error is known.
std::string study_part(const Study& study, const v1::Job& job);

}  // namespace dccast::client::render
