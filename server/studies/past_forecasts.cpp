#include "server/studies/past_forecasts.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "server/studies/known_curl.hpp"

namespace dccast::studies {

namespace {

using statistics::Departure;

/// Whether a gauge slips between a forecast and its reading, and the forecast does not know of it.
bool is_past_slip(const std::vector<Departure>& departures, double made_s, double reading_s) {
  return std::ranges::any_of(departures, [&](const Departure& departure) {
    return departure.kind == Departure::Kind::step && made_s < departure.time &&
           reading_s >= departure.begin;
  });
}

/// Walks through the readings of a gauge once more, and forecasts each from those up to `ahead_s`
/// before it.
judging::PastForecast forecast_ahead(const KnownCurl& known, double ahead_s) {
  const auto& innovations = known.learned().innovations;
  const auto& departures = known.learned().departures;
  statistics::TrajectoryForecast forecast = known.before();
  judging::PastForecast past{.monitor = known.monitor(), .ahead_s = ahead_s};
  const auto add = [&](std::size_t i) {
    const CurlReading& reading = known.readings()[i];
    const double made_s = reading.time_s - ahead_s;
    if (made_s < 0.0 || is_left_out(innovations[i])) return;
    if (is_past_slip(departures, made_s, reading.time_s)) return;

    const statistics::Estimated as_planned = forecast.expected_reading(reading.time_s);
    const v1::ExpectedCurl expected =
        expected_curl(known.with_levers(as_planned, reading.time_s, made_s));
    past.time_s.push_back(reading.time_s);
    past.measured_m.push_back(reading.curl_m);
    past.expected_m.push_back(expected.curl_m());
    past.lower_m.push_back(expected.lower_m());
    past.upper_m.push_back(expected.upper_m());
  };

  std::size_t to_come = 0;
  for (const statistics::Innovation& now : innovations) {
    // Those that are due before this reading.
    for (; to_come < innovations.size() && innovations[to_come].time - ahead_s < now.time;
         ++to_come)
      add(to_come);

    loosen_zero_at(now.time, departures, forecast);
    if (!is_left_out(now)) forecast.learn(now.time, now.reading);
  }
  return past;
}

/// Readings of a gauge that count, until it slips.
std::vector<const statistics::Innovation*> sound_readings(const LearnedCurl& learned) {
  const auto slip = std::ranges::find(learned.departures, Departure::Kind::step, &Departure::kind);
  std::vector<const statistics::Innovation*> sound;
  for (const statistics::Innovation& innovation : learned.innovations) {
    if (slip != learned.departures.end() && innovation.time >= slip->begin) break;
    if (!is_left_out(innovation)) sound.push_back(&innovation);
  }
  return sound;
}

/// The medians of the readings around a dozen times up to the end of the plan.
v1::ObservedCurl observed(const v1::Gauge& gauge, double end_s,
                          const std::vector<const statistics::Innovation*>& readings) {
  constexpr int times = 12;
  constexpr double around_s = 2.5;
  // Of normal readings the median has 1.25 times the standard deviation of the mean.
  constexpr double of_median = 1.25;

  v1::ObservedCurl curl;
  curl.set_monitor(gauge.monitor());
  for (int i = 1; i <= times; ++i) {
    const double time_s = end_s * i / times;
    std::vector<double> near;
    for (const statistics::Innovation* reading : readings)
      if (std::abs(reading->time - time_s) <= around_s) near.push_back(reading->reading);
    if (near.empty()) continue;

    const auto middle = near.begin() + std::ssize(near) / 2;
    std::ranges::nth_element(near, middle);
    curl.add_time_s(time_s);
    curl.add_curl_m(*middle);
    curl.add_deviation_m(of_median * gauge.noise_m() / std::sqrt(static_cast<double>(near.size())));
  }
  return curl;
}

}  // namespace

std::vector<judging::PastForecast> past_forecasts(const ForecastBasis& basis) {
  std::vector<judging::PastForecast> past;
  for (const v1::Gauge& gauge : basis.following.gauges()) {
    const KnownCurl known(gauge, basis);
    for (const double ahead_s : {30.0, 60.0}) past.push_back(forecast_ahead(known, ahead_s));
  }
  return past;
}

std::vector<v1::ObservedCurl> observed_curls(const ForecastBasis& basis) {
  std::vector<v1::ObservedCurl> curls;
  for (const v1::Gauge& gauge : basis.following.gauges()) {
    const KnownCurl known(gauge, basis);
    const Eigen::VectorXd& instants = known.prior().trajectory.time;
    curls.push_back(
        observed(gauge, instants(instants.size() - 1), sound_readings(known.learned())));
  }
  return curls;
}

}  // namespace dccast::studies
