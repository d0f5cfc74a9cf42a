#include "server/studies/curl_forecast.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/statistics/trajectory_forecast.hpp"
#include "proto/values/interpolation.hpp"

namespace dccast::studies {

namespace {

using statistics::TrajectoryForecast;

/// Standard deviation of the error of the model besides data and mesh, as a share of the curl. No
/// casting has been compared yet that would tell it (docs/following.md).
constexpr double model_error = 0.05;
/// Half the width of a band that holds nine of ten, in standard deviations.
constexpr double nine_of_ten = 1.645;
/// Readings farther from what was expected are left out [standard deviations].
constexpr double farthest = 4.0;

const v1::CurlCurve* curve_of(const v1::StudyRun& run, const std::string& monitor) {
  const bool counts = run.state() == v1::SUCCEEDED && !run.beyond_validity();
  const auto found = std::ranges::find(run.curves(), monitor, &v1::CurlCurve::monitor);
  return counts && found != run.curves().end() && found->time_s_size() > 1 ? &*found : nullptr;
}

std::vector<const v1::CurlCurve*> curves_of(const v1::StudyResult& ensemble,
                                            const std::string& monitor) {
  std::vector<const v1::CurlCurve*> curves;
  for (const v1::StudyRun& run : ensemble.runs())
    if (const v1::CurlCurve* curve = curve_of(run, monitor)) curves.push_back(curve);
  return curves;
}

/// Instants from the start of the block to the end of the shortest run: every second, of a long
/// casting fewer.
Eigen::VectorXd instants_of(const std::vector<const v1::CurlCurve*>& curves) {
  constexpr double most = 600.0;
  double end = INFINITY;
  for (const v1::CurlCurve* curve : curves) end = std::min(end, *curve->time_s().rbegin());
  const double count = std::clamp(std::floor(end), 2.0, most);
  return Eigen::VectorXd::LinSpaced(static_cast<Eigen::Index>(count) + 1, 0.0, end);
}

/// (member, instant) curls [m]; zero while there is none.
Eigen::MatrixXd members_at(const std::vector<const v1::CurlCurve*>& curves,
                           const Eigen::VectorXd& instants) {
  const std::vector<double> at(instants.begin(), instants.end());
  Eigen::MatrixXd members(curves.size(), instants.size());
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const v1::CurlCurve& curve = *curves[i];
    std::vector<double> curl(curve.curl_m().begin(), curve.curl_m().end());
    std::ranges::replace_if(curl, [](double each) { return !std::isfinite(each); }, 0.0);
    const auto row =
        values::at_instants(at, {curve.time_s().begin(), curve.time_s().end()}, curl);
    members.row(static_cast<Eigen::Index>(i)) =
        Eigen::RowVectorXd::Map(row.data(), static_cast<Eigen::Index>(row.size()));
  }
  return members;
}

/// The prior of an ensemble whose runs the mesh has put too low by the middle of its band.
statistics::TrajectoryPrior prior_of(const Eigen::VectorXd& instants,
                                     const Eigen::MatrixXd& members,
                                     const v1::RelativeError& mesh_error) {
  const double of_mesh = 0.5 * (mesh_error.lower() + mesh_error.upper()) / nine_of_ten;
  const Eigen::VectorXd mean = members.colwise().mean();
  auto prior = statistics::prior_of({.time = instants,
                                     .nominal = mean,
                                     .members = members,
                                     .misfits = {},
                                     .model_error = std::hypot(model_error, of_mesh)});
  prior.deviation += 0.5 * (mesh_error.upper() - mesh_error.lower()) * mean;
  return prior;
}

/// Learns from the readings of a gauge, and counts them.
void learn(TrajectoryForecast& forecast, const std::vector<v1::Reading>& readings,
           v1::ForecastCurl& curl) {
  for (const v1::Reading& reading : readings) {
    const auto measured =
        std::ranges::find(reading.curls(), curl.monitor(), &v1::MeasuredCurl::monitor);
    // Before the block starts nothing is forecast.
    if (measured == reading.curls().end() || reading.time_s() < 0.0) continue;

    const auto expected = forecast.expected_reading(reading.time_s());
    if (std::abs(measured->curl_m() - expected.value) > farthest * expected.deviation) {
      curl.set_left_out(curl.left_out() + 1);
      continue;
    }
    forecast.learn(reading.time_s(), measured->curl_m());
    curl.set_readings(curl.readings() + 1);
  }
}

v1::ForecastCurl forecast_of(const v1::Gauge& gauge, const ForecastBasis& basis, double from_s) {
  v1::ForecastCurl curl;
  curl.set_monitor(gauge.monitor());
  const auto curves = curves_of(basis.ensemble, gauge.monitor());
  curl.set_members(static_cast<int>(curves.size()));
  if (curl.members() < fewest_members)
    throw CannotForecast(fmt::format("{} runs of study {} count so far, {} are needed",
                                     curl.members(), basis.following.ensemble(), fewest_members));

  const Eigen::VectorXd instants = instants_of(curves);
  TrajectoryForecast forecast(prior_of(instants, members_at(curves, instants), basis.mesh_error),
                              {.noise = gauge.noise_m(), .zero = gauge.zero_m()});
  learn(forecast, basis.readings, curl);

  const auto add = [&](double time_s) {
    const statistics::Estimated at = forecast.at(time_s);
    curl.add_time_s(time_s);
    curl.add_curl_m(at.value);
    curl.add_lower_m(at.value - nine_of_ten * at.deviation);
    curl.add_upper_m(at.value + nine_of_ten * at.deviation);
  };
  const double begin_s = std::max(from_s, 0.0);
  add(begin_s);
  for (const double time_s : instants)
    if (time_s > begin_s) add(time_s);

  const statistics::Estimated zero = forecast.zero();
  curl.set_zero_m(zero.value);
  curl.set_zero_lower_m(zero.value - nine_of_ten * zero.deviation);
  curl.set_zero_upper_m(zero.value + nine_of_ten * zero.deviation);
  return curl;
}

}  // namespace

v1::Forecast forecast_curls(const ForecastBasis& basis) {
  v1::Forecast forecast;
  for (const v1::Reading& reading : basis.readings)
    if (!reading.closes()) forecast.set_time_s(reading.time_s());
  for (const v1::Gauge& gauge : basis.following.gauges())
    *forecast.add_curls() = forecast_of(gauge, basis, forecast.time_s());
  return forecast;
}

}  // namespace dccast::studies
