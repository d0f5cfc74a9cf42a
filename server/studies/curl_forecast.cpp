#include "server/studies/curl_forecast.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "core/statistics/innovations.hpp"
#include "core/statistics/trajectory_forecast.hpp"
#include "proto/values/interpolation.hpp"
#include "server/studies/levers_off_plan.hpp"

namespace dccast::studies {

namespace {

using statistics::Departure;
using statistics::TrajectoryForecast;

/// Standard deviation of the error of the model besides data and mesh, as a share of the curl. No
/// casting has been compared yet that would tell it (docs/following.md).
constexpr double model_error = 0.05;
/// Half the width of a band that holds nine of ten, in standard deviations.
constexpr double nine_of_ten = 1.645;
/// Pairs that tell the error of the mesh at least: fewer have no scatter.
constexpr Eigen::Index fewest_pairs = 2;

bool counts(const v1::StudyRun& run) {
  return run.state() == v1::SUCCEEDED && !run.beyond_validity();
}

/// The curve of a run that counts; null: it has none.
const v1::CurlCurve* curve_of(const v1::StudyRun& run, const std::string& monitor) {
  const auto found = std::ranges::find(run.curves(), monitor, &v1::CurlCurve::monitor);
  return counts(run) && found != run.curves().end() && found->time_s_size() > 1 ? &*found : nullptr;
}

using Curves = std::vector<const v1::CurlCurve*>;

/// Curves of a gauge: of all members, and of those that were also run at a finer quality.
struct Trajectories {
  Curves members;
  /// (pair) of equal data
  Curves fine, coarse;
};

Trajectories trajectories_of(const ForecastBasis& basis, const std::string& monitor) {
  Trajectories found;
  for (const v1::StudyRun& run : basis.ensemble.runs())
    if (const v1::CurlCurve* curve = curve_of(run, monitor)) found.members.push_back(curve);

  for (const v1::StudyRun& pair : basis.pairs.runs()) {
    const auto member = std::ranges::find_if(basis.ensemble.runs(), [&](const v1::StudyRun& run) {
      return std::ranges::equal(run.values(), pair.values());
    });
    if (member == basis.ensemble.runs().end()) continue;
    const v1::CurlCurve *fine = curve_of(pair, monitor), *coarse = curve_of(*member, monitor);
    if (!fine || !coarse) continue;
    found.fine.push_back(fine);
    found.coarse.push_back(coarse);
  }
  return found;
}

/// Instants from the start of the block to the end of the shortest run: every second, of a long
/// casting fewer.
Eigen::VectorXd instants_of(const Trajectories& trajectories) {
  constexpr double most = 600.0;
  double end = INFINITY;
  for (const Curves* curves : {&trajectories.members, &trajectories.fine})
    for (const v1::CurlCurve* curve : *curves) end = std::min(end, *curve->time_s().rbegin());
  const double count = std::clamp(std::floor(end), 2.0, most);
  return Eigen::VectorXd::LinSpaced(static_cast<Eigen::Index>(count) + 1, 0.0, end);
}

/// (curve, instant) curls [m]; zero while there is none.
Eigen::MatrixXd curls_at(const Eigen::VectorXd& instants, const Curves& curves) {
  const std::vector<double> at(instants.begin(), instants.end());
  Eigen::MatrixXd curls(curves.size(), instants.size());
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const v1::CurlCurve& curve = *curves[i];
    std::vector<double> curl(curve.curl_m().begin(), curve.curl_m().end());
    std::ranges::replace_if(curl, [](double each) { return !std::isfinite(each); }, 0.0);
    const auto row =
        values::at_instants(at, {curve.time_s().begin(), curve.time_s().end()}, curl);
    curls.row(static_cast<Eigen::Index>(i)) =
        Eigen::RowVectorXd::Map(row.data(), static_cast<Eigen::Index>(row.size()));
  }
  return curls;
}

/// The error of mesh and time steps of a study's runs; zero where it was not measured.
v1::RelativeError mesh_error_of(const v1::StudyResult& study) {
  const auto run = std::ranges::find_if(study.runs(), &v1::StudyRun::has_mesh_error);
  return run == study.runs().end() ? v1::RelativeError() : run->mesh_error();
}

/// The prior of the members. Pairs tell how far they are from the finer quality. What that leaves,
/// or without pairs the members themselves, the band of the quality tells: by its middle they are
/// too low, and half its width is the error of nine in ten.
statistics::TrajectoryPrior prior_of(const Trajectories& trajectories, const ForecastBasis& basis) {
  const Eigen::VectorXd instants = instants_of(trajectories);
  const Eigen::MatrixXd members = curls_at(instants, trajectories.members);
  const Eigen::VectorXd mean = members.colwise().mean();
  statistics::TrajectoryEnsemble ensemble{
      .time = instants,
      .nominal = mean,
      .members = members,
      .misfits = curls_at(instants, trajectories.fine) - curls_at(instants, trajectories.coarse),
      .model_error = model_error};
  const bool has_pairs = ensemble.misfits.rows() >= fewest_pairs;
  const v1::RelativeError mesh_error = mesh_error_of(has_pairs ? basis.pairs : basis.ensemble);

  const double of_mesh = 0.5 * (mesh_error.lower() + mesh_error.upper()) / nine_of_ten;
  ensemble.model_error = std::hypot(model_error, of_mesh);
  auto prior = statistics::prior_of(ensemble);
  const double too_low = 0.5 * (mesh_error.upper() - mesh_error.lower());
  prior.deviation += too_low * (prior.nominal + prior.deviation);
  return prior;
}

/// Learns from the readings of a gauge, and counts them.
/// @param slips  at which the zero of the gauge becomes unknown again
/// @return all readings, with what was expected
std::vector<statistics::Innovation> learn(TrajectoryForecast& forecast,
                                          const std::vector<v1::Reading>& readings,
                                          const std::vector<Departure>& slips,
                                          v1::ForecastCurl& curl) {
  const TrajectoryForecast before = forecast;
  std::vector<statistics::Innovation> innovations;
  curl.clear_readings();
  curl.clear_left_out();
  for (const v1::Reading& reading : readings) {
    const auto measured =
        std::ranges::find(reading.curls(), curl.monitor(), &v1::MeasuredCurl::monitor);
    // Before the block starts nothing is forecast.
    const double time_s = reading.time_s();
    if (measured == reading.curls().end() || time_s < 0.0) continue;

    for (const Departure& slip : slips)
      if (slip.begin == time_s) forecast.loosen_zero(slip.size);

    innovations.push_back({.time = time_s,
                           .reading = measured->curl_m(),
                           .first_mean = before.expected_reading(time_s).value,
                           .expected = forecast.expected_reading(time_s)});
    if (std::abs(statistics::normalised(innovations.back())) > statistics::farthest_innovation) {
      curl.set_left_out(curl.left_out() + 1);
      continue;
    }
    forecast.learn(time_s, measured->curl_m());
    curl.set_readings(curl.readings() + 1);
  }
  return innovations;
}

/// What all readings of a gauge tell.
struct Learned {
  TrajectoryForecast forecast;
  std::vector<Departure> departures;  ///< by time
};

/// Learns from all readings of a gauge. Where it has slipped they are learned once more, with a zero
/// that is unknown again from there on; otherwise the slip would be taken for curl.
Learned learned_from(const TrajectoryForecast& prior, const v1::Gauge& gauge,
                     const std::vector<v1::Reading>& readings, v1::ForecastCurl& curl) {
  constexpr std::size_t most_slips = 8;
  std::vector<Departure> slips;
  for (;;) {
    Learned learned{prior, {}};
    const auto innovations = learn(learned.forecast, readings, slips, curl);
    learned.departures = statistics::find_departures(innovations, gauge.noise_m());
    const auto slip = std::ranges::find(learned.departures, Departure::Kind::step, &Departure::kind);
    if (slip != learned.departures.end() && slips.size() < most_slips) {
      slips.push_back(*slip);
      continue;
    }

    learned.departures.insert(learned.departures.end(), slips.begin(), slips.end());
    std::ranges::stable_sort(learned.departures, {}, &Departure::time);
    return learned;
  }
}

v1::ForecastWarning warning_of(const Departure& departure, const std::string& monitor) {
  v1::ForecastWarning warning;
  warning.set_time_s(departure.time);
  warning.set_monitor(monitor);
  const double mm = 1e3 * std::abs(departure.size);

  if (departure.kind == Departure::Kind::step) {
    warning.set_text(fmt::format("from {:.0f} s on the gauge shows {:.1f} mm {}", departure.begin,
                                 mm, departure.size > 0.0 ? "more" : "less"));
    warning.add_causes("the gauge has slipped");
    return warning;
  }

  warning.set_text(fmt::format("the measured curl is {:.1f} mm {} what plan and data permit, on "
                               "average since {:.0f} s",
                               mm, departure.size > 0.0 ? "above" : "below", departure.begin));
  // In the order of their usual size.
  for (const char* cause : {"water", "metal temperature", "casting speed"})
    warning.add_causes(cause);
  return warning;
}

/// Adds the curl at a gauge, and its warnings.
void add_curl(const v1::Gauge& gauge, const ForecastBasis& basis, v1::Forecast& to) {
  v1::ForecastCurl& curl = *to.add_curls();
  curl.set_monitor(gauge.monitor());
  const Trajectories trajectories = trajectories_of(basis, gauge.monitor());
  curl.set_members(static_cast<int>(trajectories.members.size()));
  if (curl.members() < fewest_members)
    throw CannotForecast(fmt::format("{} runs of study {} count so far, {} are needed",
                                     curl.members(), basis.following.ensemble(), fewest_members));

  const statistics::TrajectoryPrior prior = prior_of(trajectories, basis);
  const auto [forecast, departures] = learned_from(
      TrajectoryForecast(prior, {.noise = gauge.noise_m(), .zero = gauge.zero_m()}), gauge,
      basis.readings, curl);
  for (const Departure& departure : departures)
    *to.add_warnings() = warning_of(departure, gauge.monitor());

  const auto add = [&](double time_s) {
    const statistics::Estimated at = forecast.at(time_s);
    curl.add_time_s(time_s);
    curl.add_curl_m(at.value);
    curl.add_lower_m(at.value - nine_of_ten * at.deviation);
    curl.add_upper_m(at.value + nine_of_ten * at.deviation);
  };
  const double begin_s = std::max(to.time_s(), 0.0);
  add(begin_s);
  for (const double time_s : prior.time)
    if (time_s > begin_s) add(time_s);

  const statistics::Estimated zero = forecast.zero();
  curl.set_zero_m(zero.value);
  curl.set_zero_lower_m(zero.value - nine_of_ten * zero.deviation);
  curl.set_zero_upper_m(zero.value + nine_of_ten * zero.deviation);
}

/// When a run has each of its findings beyond notes first [s].
std::map<std::string, double> first_times(const v1::StudyRun& run) {
  std::map<std::string, double> times;
  for (const v1::Finding& finding : run.findings()) {
    if (finding.severity() < v1::Finding::WARNING || !finding.has_time_s()) continue;
    const auto [first, is_new] = times.try_emplace(finding.code(), finding.time_s());
    if (!is_new) first->second = std::min(first->second, finding.time_s());
  }
  return times;
}

/// Counts the members that have a finding first after the last reading.
void add_findings_to_come(const v1::StudyResult& ensemble, std::optional<double> last_s,
                          v1::Forecast& to) {
  std::map<std::string, int> members;
  int of = 0;
  for (const v1::StudyRun& run : ensemble.runs()) {
    if (!counts(run)) continue;
    ++of;
    for (const auto& [rule, time_s] : first_times(run))
      if (!last_s || time_s > *last_s) ++members[rule];
  }

  for (const auto& [rule, count] : members) {
    v1::ForecastFinding& finding = *to.add_findings();
    finding.set_rule(rule);
    finding.set_members(count);
    finding.set_of(of);
  }
  std::ranges::stable_sort(*to.mutable_findings(), std::greater<>(), &v1::ForecastFinding::members);
}

/// Says where the forecast rests on less than it could.
void add_notes(const ForecastBasis& basis, v1::Forecast& to) {
  const auto lost = std::ranges::count_if(
      basis.ensemble.runs(), [](const v1::StudyRun& run) { return !counts(run); });
  if (lost > 0)
    to.add_notes(fmt::format("{} of {} runs of the ensemble do not count: they have not ended, "
                             "failed, or left what the model holds for",
                             lost, basis.ensemble.runs_size()));

  for (const std::string& lever : levers_off_plan(basis.plan, basis.readings)) to.add_notes(lever);
}

}  // namespace

v1::Forecast forecast_curls(const ForecastBasis& basis) {
  v1::Forecast forecast;
  std::optional<double> last_s;
  for (const v1::Reading& reading : basis.readings)
    if (!reading.closes()) last_s = reading.time_s();
  forecast.set_time_s(last_s.value_or(0.0));

  for (const v1::Gauge& gauge : basis.following.gauges()) add_curl(gauge, basis, forecast);
  std::ranges::stable_sort(*forecast.mutable_warnings(), {}, &v1::ForecastWarning::time_s);
  add_findings_to_come(basis.ensemble, last_s, forecast);
  add_notes(basis, forecast);
  return forecast;
}

}  // namespace dccast::studies
