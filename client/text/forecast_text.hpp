#pragma once

#include <string>

#include "dccast/v1/follow.pb.h"

namespace dccast::client {

/// "corner: 4.1 mm more than expected; likeliest: a gauge that slipped", without its time.
std::string warning_text(const v1::ForecastWarning& warning);

/// "forecast at 90 s: corner 18.2 mm at 150 s (16.0 to 20.5), 36.1 mm at the end (33.0 to 39.2)".
std::string forecast_line(const v1::Forecast& forecast);

/// A minute after the last reading, within the times of a curl [s].
double soon_s(const v1::Forecast& forecast, const v1::ForecastCurl& curl);

/// A curl of a forecast at one time [mm].
struct CurlToCome {
  double curl_mm, lower_mm, upper_mm;
};
/// @param at_s  within the times of the forecast
CurlToCome curl_to_come(const v1::ForecastCurl& curl, double at_s);

}  // namespace dccast::client
