#include "server/studies/known_curl.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "server/studies/run_curves.hpp"

namespace dccast::studies {

namespace {

using statistics::Departure;
using statistics::TrajectoryForecast;

/// Readings of a gauge. Before the block starts nothing is forecast.
std::vector<CurlReading> readings_of(const std::string& monitor,
                                     const std::vector<v1::Reading>& readings) {
  std::vector<CurlReading> curls;
  for (const v1::Reading& reading : readings) {
    const auto measured = std::ranges::find(reading.curls(), monitor, &v1::MeasuredCurl::monitor);
    if (measured != reading.curls().end() && reading.time_s() >= 0.0)
      curls.push_back({reading.time_s(), measured->curl_m()});
  }
  return curls;
}

/// What the levers did at a gauge; nothing where one of the runs is not known.
ExecutedLevers executed_levers(const ForecastBasis& basis, const std::string& monitor) {
  const v1::CurlCurve* const followed = find_curve(basis.followed_run, monitor);
  const v1::CurlCurve* const planned = find_curve(basis.plan_run, monitor);
  if (!followed || !planned) return {};
  return {*followed, *planned};
}

statistics::Gauge gauge_of(const v1::Gauge& gauge) {
  return {.noise = gauge.noise_m(), .zero = gauge.zero_m()};
}

/// Learns from readings of a gauge.
/// @param slips  at which the zero of the gauge becomes unknown again
LearnedCurl learn(const TrajectoryForecast& before, const std::vector<CurlReading>& readings,
                  const std::vector<Departure>& slips) {
  LearnedCurl learned{before, {}, {}};
  for (const auto& [time_s, curl_m] : readings) {
    loosen_zero_at(time_s, slips, learned.forecast);
    learned.innovations.push_back({.time = time_s,
                                   .reading = curl_m,
                                   .first_mean = before.expected_reading(time_s).value,
                                   .expected = learned.forecast.expected_reading(time_s)});
    if (!is_left_out(learned.innovations.back())) learned.forecast.learn(time_s, curl_m);
  }
  return learned;
}

/// By what factor innovations may be larger than the prior permits, since its members are, against
/// the curl [m].
Curve scale_of(const CurlPrior& prior, const statistics::Gauge& gauge) {
  if (!prior.ensemble) return Curve(1.0);
  return statistics::member_scale(*prior.ensemble, gauge);
}

/// Learns from readings of a gauge, once more after each slip that they show.
LearnedCurl learn_with_slips(const TrajectoryForecast& before, double noise_m, const Curve& scale,
                             const std::vector<CurlReading>& readings) {
  constexpr std::size_t most_slips = 8;
  std::vector<Departure> slips;
  for (;;) {
    LearnedCurl learned = learn(before, readings, slips);
    learned.departures = statistics::find_departures(learned.innovations, noise_m, scale);
    const auto slip =
        std::ranges::find(learned.departures, Departure::Kind::step, &Departure::kind);
    if (slip != learned.departures.end() && slips.size() < most_slips) {
      slips.push_back(*slip);
      continue;
    }

    learned.departures.insert(learned.departures.end(), slips.begin(), slips.end());
    std::ranges::stable_sort(learned.departures, {}, &Departure::time);
    return learned;
  }
}

}  // namespace

KnownCurl::KnownCurl(const v1::Gauge& gauge, const ForecastBasis& basis)
    : monitor_(gauge.monitor()),
      levers_(executed_levers(basis, monitor_)),
      off_plan_(levers::plan_departures(basis.plan, basis.readings)),
      prior_(prior_of_curl(basis, monitor_)),
      before_(prior_.trajectory, gauge_of(gauge)),
      readings_(readings_of(monitor_, basis.readings)),
      wrong_gauge_(find_wrong_gauge(before_, prior_.trajectory.time, levers_, readings_)),
      learned_(learn_with_slips(before_, gauge.noise_m(), scale_of(prior_, gauge_of(gauge)),
                                wrong_gauge_ ? std::vector<CurlReading>() : as_planned())) {}

std::vector<CurlReading> KnownCurl::as_planned() const {
  std::vector<CurlReading> planned = readings_;
  for (CurlReading& reading : planned) reading.curl_m -= levers_.effect_at(reading.time_s).value;
  return planned;
}

statistics::Estimated KnownCurl::with_levers(const statistics::Estimated& as_planned, double time_s,
                                             double known_until_s) const {
  const auto after =
      std::ranges::upper_bound(off_plan_, known_until_s, {}, &levers::PlanDeparture::time_s);
  const double off = after == off_plan_.begin() ? 0.0 : std::prev(after)->share;
  const double otherwise = off * minute_share(time_s, known_until_s) * before_.at(time_s).deviation;

  const statistics::Estimated effect = levers_.effect_at(time_s, known_until_s);
  return {as_planned.value + effect.value,
          std::hypot(as_planned.deviation, effect.deviation, otherwise)};
}

v1::ExpectedCurl expected_curl(const statistics::Estimated& estimated) {
  const double half = nine_of_ten * estimated.deviation;
  v1::ExpectedCurl curl;
  curl.set_curl_m(estimated.value);
  curl.set_lower_m(estimated.value - half);
  curl.set_upper_m(estimated.value + half);
  return curl;
}

bool is_left_out(const statistics::Innovation& innovation) {
  return std::abs(statistics::normalised(innovation)) > statistics::farthest_innovation;
}

void loosen_zero_at(double time_s, const std::vector<Departure>& departures,
                    TrajectoryForecast& forecast) {
  for (const Departure& departure : departures)
    if (departure.kind == Departure::Kind::step && departure.begin == time_s)
      forecast.loosen_zero(departure.size);
}

}  // namespace dccast::studies
