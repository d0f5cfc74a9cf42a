#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "server/studies/curl_forecast.hpp"

/// Castings whose curl is one shape times a factor: of runs, and as a gauge shows it.
namespace dccast::studies {

inline constexpr double end_s = 120.0;

inline double shape(double time_s) {
  return time_s <= 0.0 ? 0.0 : 0.03 * (1.0 - std::exp(-time_s / 40.0));
}

/// Runs whose curls are a shape times 0.8 to 1.2.
inline v1::StudyResult ensemble(int members) {
  v1::StudyResult result;
  for (int i = 0; i < members; ++i) {
    v1::StudyRun& run = *result.add_runs();
    run.set_state(v1::SUCCEEDED);
    run.add_values(fmt::format("{} W/m/K", 100 + i));
    v1::CurlCurve& curve = *run.add_curves();
    curve.set_monitor("corner");
    for (double t = -30.0; t <= end_s; t += 2.0) {
      curve.add_time_s(t);
      curve.add_curl_m(t < 0.0 ? NAN : (0.8 + 0.4 * i / (members - 1)) * shape(t));
    }
  }
  return result;
}

inline v1::Following following(double zero_m = 0.0) {
  v1::Following with;
  with.set_ensemble("study");
  v1::Gauge& gauge = *with.add_gauges();
  gauge.set_monitor("corner");
  gauge.set_noise_m(0.5e-3);
  gauge.set_zero_m(zero_m);
  return with;
}

/// Readings of every second of a casting whose curl is the shape times a factor.
inline std::vector<v1::Reading> readings(double factor, double until_s) {
  std::vector<v1::Reading> made;
  for (double t = -10.0; t <= until_s; t += 1.0) {
    v1::Reading& reading = made.emplace_back();
    reading.set_time_s(t);
    v1::MeasuredCurl& curl = *reading.add_curls();
    curl.set_monitor("corner");
    curl.set_curl_m(factor * shape(t));
  }
  return made;
}

inline v1::Case plan() {
  v1::Case complete;
  complete.mutable_schedule()->mutable_casting_speed_m_per_s()->add_value(1e-3);
  complete.mutable_schedule()->mutable_water_flow_m2_per_s()->add_value(2e-3);
  complete.mutable_time()->set_end_s(1e4);
  complete.mutable_cooling()->mutable_water()->set_enabled(true);
  return complete;
}

/// Runs whose curls are off by the mesh, -4 +10 %.
inline v1::StudyResult with_band(v1::StudyResult runs) {
  for (v1::StudyRun& run : *runs.mutable_runs()) {
    run.mutable_mesh_error()->set_lower(0.04);
    run.mutable_mesh_error()->set_upper(0.10);
  }
  return runs;
}

/// Asks a forecast, past ones or what is observed. @param ask  of a ForecastBasis
template <typename Ask>
auto ask_of(const v1::StudyResult& runs, const std::vector<v1::Reading>& measured, Ask ask,
            const v1::StudyResult& pairs = {}, double zero_m = 0.0) {
  const v1::Following with = following(zero_m);
  const v1::Case complete = plan();
  return ask(ForecastBasis{
      .ensemble = runs, .pairs = pairs, .plan = complete, .following = with, .readings = measured});
}

inline v1::Forecast whole_forecast(const v1::StudyResult& runs,
                                   const std::vector<v1::Reading>& measured,
                                   const v1::StudyResult& pairs = {}) {
  return ask_of(runs, measured, forecast_curls, pairs);
}

inline v1::ForecastCurl forecast(const v1::StudyResult& runs,
                                 const std::vector<v1::Reading>& measured,
                                 const v1::StudyResult& pairs = {}) {
  return whole_forecast(runs, measured, pairs).curls(0);
}

inline double width_at_end(const v1::ForecastCurl& curl) {
  return *curl.upper_m().rbegin() - *curl.lower_m().rbegin();
}

/// Readings whose gauge is off from a time on, with a noise of half a millimetre.
inline std::vector<v1::Reading> faulty(double slip_m, double drift_m_per_s, unsigned seed = 3) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, 0.5e-3);
  auto made = readings(1.1, 100.0);
  for (v1::Reading& reading : made) {
    const double after = reading.time_s() - 60.0;
    const double off = after < 0.0 ? 0.0 : slip_m + drift_m_per_s * after;
    v1::MeasuredCurl& curl = *reading.mutable_curls(0);
    curl.set_curl_m(curl.curl_m() + off + noise(random));
  }
  return made;
}

/// What levers that leave the plan at 30 s have done by a time: up to 4 mm at 70 s.
inline double done_by_levers(double time_s) {
  return 4e-3 * std::clamp((time_s - 30.0) / 40.0, 0.0, 1.0);
}

inline v1::CurlCurve run_until(double until_s, bool has_plan_levers) {
  v1::CurlCurve curve;
  curve.set_monitor("corner");
  for (double t = 0.0; t <= until_s; t += 2.0) {
    curve.add_time_s(t);
    curve.add_curl_m(shape(t) + (has_plan_levers ? 0.0 : done_by_levers(t)));
  }
  return curve;
}

/// A casting whose curl is the shape times 1.1 and what the levers have done.
inline std::vector<v1::Reading> off_plan(double until_s) {
  auto made = readings(1.1, until_s);
  for (v1::Reading& reading : made) {
    v1::MeasuredCurl& curl = *reading.mutable_curls(0);
    curl.set_curl_m(curl.curl_m() + done_by_levers(reading.time_s()));
  }
  return made;
}

/// Asks a forecast of a casting off the plan, with the run that follows it up to a time.
template <typename Ask>
auto ask_off_plan(double until_s, const std::vector<v1::Reading>& measured, Ask ask) {
  const v1::StudyResult runs = ensemble(21), pairs;
  const v1::Following with = following();
  const v1::Case complete = plan();
  return ask(ForecastBasis{.ensemble = runs,
                           .pairs = pairs,
                           .plan = complete,
                           .following = with,
                           .readings = measured,
                           .plan_run = {run_until(end_s, true)},
                           .followed_run = {run_until(until_s, false)}});
}

}  // namespace dccast::studies
