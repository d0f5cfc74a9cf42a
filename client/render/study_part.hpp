#pragma once

#include <optional>
#include <string>

#include "client/render/svg_chart.hpp"
#include "client/study.hpp"

namespace dccast::client::render {

/// What a study says of the curl of one of its runs.
struct CurlError {
  double this_run_m = 0.0;  ///< distance to the limit and the limit's uncertainty together
  double limit_m = 0.0;
  double uncertainty_m = 0.0;  ///< of the limit
  bool extrapolated = false;   ///< else the limit is the curl of the finest run
};

/// @return nothing where the study says nothing of this monitor at this time
std::optional<CurlError> curl_error(const Study& study, const std::string& monitor, double time_s,
                                    double curl_m);

/// Limit and interval of a monitor [mm] against time [s] or cast length [mm], thinned to what can
/// be told apart in a chart; thinning widens it where it must, so that it never shows less than
/// there is.
ChartBand curl_band(const Study& study, const std::string& monitor, bool against_length);

/// The card "How much of it is discretisation" of a job's report, or the line that says that no
/// error is known and which command tells it.
std::string study_part(const Study& study, const v1::Job& job);

}  // namespace dccast::client::render
