#include "client/text/forecast_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "proto/values/interpolation.hpp"

namespace dccast::client {

std::string warning_text(const v1::ForecastWarning& warning) {
  return fmt::format("{}: {}; likeliest: {}", warning.monitor(), warning.text(),
                     fmt::join(warning.causes(), ", "));
}

CurlToCome curl_to_come(const v1::ForecastCurl& curl, double at_s) {
  const std::vector<double> times(curl.time_s().begin(), curl.time_s().end());
  const auto mm = [&](const google::protobuf::RepeatedField<double>& values) {
    return 1e3 * values::at_instants({at_s}, times, {values.begin(), values.end()}).front();
  };
  return {
      .curl_mm = mm(curl.curl_m()), .lower_mm = mm(curl.lower_m()), .upper_mm = mm(curl.upper_m())};
}

double soon_s(const v1::Forecast& forecast, const v1::ForecastCurl& curl) {
  constexpr double ahead_s = 60.0;
  return std::clamp(forecast.time_s() + ahead_s, curl.time_s(0), *curl.time_s().rbegin());
}

std::string forecast_line(const v1::Forecast& forecast) {
  std::vector<std::string> parts;
  for (const v1::ForecastCurl& curl : forecast.curls()) {
    const double end_s = *curl.time_s().rbegin();
    const double then_s = soon_s(forecast, curl);
    const auto text = [&](double at_s) {
      const CurlToCome there = curl_to_come(curl, at_s);
      return fmt::format("{:.1f} mm{} ({:.1f} to {:.1f})", there.curl_mm,
                         at_s < end_s ? fmt::format(" at {:.0f} s", at_s) : " at the end",
                         there.lower_mm, there.upper_mm);
    };
    parts.push_back(curl.monitor() + " " + (then_s < end_s ? text(then_s) + ", " : "") +
                    text(end_s));
  }
  return fmt::format("forecast at {:.0f} s: {}", forecast.time_s(), fmt::join(parts, "; "));
}

}  // namespace dccast::client
