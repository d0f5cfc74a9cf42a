#include "server/studies/curl_forecast.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "core/statistics/innovations.hpp"
#include "core/statistics/trajectory_forecast.hpp"
#include "server/judging/judged_study.hpp"
#include "server/studies/advice.hpp"
#include "server/studies/curl_prior.hpp"
#include "server/studies/executed_levers.hpp"
#include "server/studies/levers_off_plan.hpp"

namespace dccast::studies {

namespace {

using statistics::Departure;
using statistics::TrajectoryForecast;

bool is_left_out(const statistics::Innovation& innovation) {
  return std::abs(statistics::normalised(innovation)) > statistics::farthest_innovation;
}

/// A curl that was measured.
struct CurlReading {
  double time_s;
  double curl_m;
};

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

/// Learns from readings of a gauge.
/// @param slips  at which the zero of the gauge becomes unknown again
/// @return all readings, with what was expected
std::vector<statistics::Innovation> learn(TrajectoryForecast& forecast,
                                          const std::vector<CurlReading>& readings,
                                          const std::vector<Departure>& slips) {
  const TrajectoryForecast before = forecast;
  std::vector<statistics::Innovation> innovations;
  for (const auto& [time_s, curl_m] : readings) {
    for (const Departure& slip : slips)
      if (slip.begin == time_s) forecast.loosen_zero(slip.size);

    innovations.push_back({.time = time_s,
                           .reading = curl_m,
                           .first_mean = before.expected_reading(time_s).value,
                           .expected = forecast.expected_reading(time_s)});
    if (!is_left_out(innovations.back())) forecast.learn(time_s, curl_m);
  }
  return innovations;
}

/// What all readings of a gauge tell.
struct Learned {
  TrajectoryForecast forecast;
  std::vector<statistics::Innovation> innovations;
  std::vector<Departure> departures;  ///< by time
};

/// Learns from all readings of a gauge. Where it has slipped they are learned once more, with a zero
/// that is unknown again from there on; otherwise the slip would be taken for curl.
Learned learned_from(const TrajectoryForecast& before, double noise_m,
                     const std::vector<CurlReading>& readings) {
  constexpr std::size_t most_slips = 8;
  std::vector<Departure> slips;
  for (;;) {
    Learned learned{before, {}, {}};
    learned.innovations = learn(learned.forecast, readings, slips);
    learned.departures = statistics::find_departures(learned.innovations, noise_m);
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

statistics::Gauge gauge_of(const v1::Gauge& gauge) {
  return {.noise = gauge.noise_m(), .zero = gauge.zero_m()};
}

/// What the levers did at a gauge; nothing where one of the runs is not known.
ExecutedLevers executed_levers(const ForecastBasis& basis, const std::string& monitor) {
  const auto followed = std::ranges::find(basis.followed_run, monitor, &v1::CurlCurve::monitor);
  const auto planned = std::ranges::find(basis.plan_run, monitor, &v1::CurlCurve::monitor);
  if (followed == basis.followed_run.end() || planned == basis.plan_run.end()) return {};
  return {*followed, *planned};
}

/// What is known of the curl at a gauge. Trajectories are those of the casting with its levers as
/// planned: what the executed levers did is taken from each reading, and given to each forecast.
struct KnownCurl {
  KnownCurl(const v1::Gauge& gauge, const ForecastBasis& basis)
      : monitor(gauge.monitor()),
        levers(executed_levers(basis, monitor)),
        prior(prior_of_curl(basis, monitor)),
        before(prior.trajectory, gauge_of(gauge)),
        departures(plan_departures(basis.plan, basis.readings)),
        readings(readings_of(monitor, basis.readings)),
        learned(learned_from(before, gauge.noise_m(), as_planned())) {}

  std::vector<CurlReading> as_planned() const {
    std::vector<CurlReading> planned = readings;
    for (CurlReading& reading : planned) reading.curl_m -= levers.effect_at(reading.time_s).value;
    return planned;
  }

  /// What levers off the plan do at a time, as it is known at an earlier one. The members have their
  /// levers as planned, and scatter otherwise than castings off the plan. So a minute later their
  /// scatter counts once more, times the share by which the levers have been off.
  statistics::Estimated done_by_levers(double time_s, double known_until_s) const {
    const auto after = std::ranges::upper_bound(departures, known_until_s, {}, &PlanDeparture::time_s);
    const double off = after == departures.begin() ? 0.0 : std::prev(after)->share;
    const double otherwise =
        off * share_of_minute(time_s, known_until_s) * before.at(time_s).deviation;

    const statistics::Estimated effect = levers.effect_at(time_s, known_until_s);
    return {effect.value, std::hypot(effect.deviation, otherwise)};
  }

  std::string monitor;
  ExecutedLevers levers;
  CurlPrior prior;
  TrajectoryForecast before;              ///< has learned nothing
  std::vector<PlanDeparture> departures;  ///< by time
  std::vector<CurlReading> readings;      ///< as they were measured
  Learned learned;
};

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

/// The sum of two that are independent.
statistics::Estimated operator+(const statistics::Estimated& one, const statistics::Estimated& other) {
  return {one.value + other.value, std::hypot(one.deviation, other.deviation)};
}

/// With the band that holds nine of ten.
v1::ExpectedCurl expected_curl(const statistics::Estimated& estimated) {
  const double half = nine_of_ten * estimated.deviation;
  v1::ExpectedCurl curl;
  curl.set_curl_m(estimated.value);
  curl.set_lower_m(estimated.value - half);
  curl.set_upper_m(estimated.value + half);
  return curl;
}

/// Adds what the gauge has shown, evenly thinned.
void add_measured(const std::vector<CurlReading>& readings, v1::ForecastCurl& to) {
  constexpr std::size_t most = 500;
  const std::size_t stride = readings.size() / most + 1;
  for (std::size_t i = readings.empty() ? 0 : (readings.size() - 1) % stride; i < readings.size();
       i += stride) {
    to.add_measured_time_s(readings[i].time_s);
    to.add_measured_m(readings[i].curl_m);
  }
}

/// Adds the curl at a gauge, its warnings, and why castings on the line do not count.
void add_curl(const v1::Gauge& gauge, const ForecastBasis& basis, v1::Forecast& to) {
  const KnownCurl known(gauge, basis);
  const Learned& learned = known.learned;

  v1::ForecastCurl& curl = *to.add_curls();
  curl.set_monitor(known.monitor);
  curl.set_members(known.prior.members);
  if (known.prior.line) *curl.mutable_line() = *known.prior.line;
  for (const std::string& note : known.prior.notes) to.add_notes(note);

  curl.set_left_out(static_cast<int>(std::ranges::count_if(learned.innovations, is_left_out)));
  curl.set_readings(static_cast<int>(std::ssize(known.readings)) - curl.left_out());
  add_measured(known.readings, curl);
  for (const Departure& departure : learned.departures)
    *to.add_warnings() = warning_of(departure, known.monitor);

  const Eigen::VectorXd& instants = known.prior.trajectory.time;
  *curl.mutable_before() = expected_curl(known.before.at(instants(instants.size() - 1)));
  const auto add = [&](double time_s) {
    const v1::ExpectedCurl at =
        expected_curl(learned.forecast.at(time_s) + known.done_by_levers(time_s, to.time_s()));
    curl.add_time_s(time_s);
    curl.add_curl_m(at.curl_m());
    curl.add_lower_m(at.lower_m());
    curl.add_upper_m(at.upper_m());
  };
  const double begin_s = std::max(to.time_s(), 0.0);
  add(begin_s);
  for (const double time_s : instants)
    if (time_s > begin_s) add(time_s);

  const v1::ExpectedCurl zero = expected_curl(learned.forecast.zero());
  curl.set_zero_m(zero.curl_m());
  curl.set_zero_lower_m(zero.lower_m());
  curl.set_zero_upper_m(zero.upper_m());
}

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
  const auto& innovations = known.learned.innovations;
  const auto& departures = known.learned.departures;
  TrajectoryForecast forecast = known.before;
  judging::PastForecast past{.monitor = known.monitor, .ahead_s = ahead_s};
  const auto add = [&](std::size_t i) {
    const CurlReading& reading = known.readings[i];
    const double made_s = reading.time_s - ahead_s;
    if (made_s < 0.0 || is_left_out(innovations[i])) return;
    if (is_past_slip(departures, made_s, reading.time_s)) return;

    const v1::ExpectedCurl expected =
        expected_curl(forecast.expected_reading(reading.time_s) +
                      known.done_by_levers(reading.time_s, made_s));
    past.time_s.push_back(reading.time_s);
    past.measured_m.push_back(reading.curl_m);
    past.expected_m.push_back(expected.curl_m());
    past.lower_m.push_back(expected.lower_m());
    past.upper_m.push_back(expected.upper_m());
  };

  std::size_t to_come = 0;
  for (const statistics::Innovation& now : innovations) {
    // Those that are due before this reading.
    for (; to_come < innovations.size() && innovations[to_come].time - ahead_s < now.time; ++to_come)
      add(to_come);

    for (const Departure& departure : departures)
      if (departure.kind == Departure::Kind::step && departure.begin == now.time)
        forecast.loosen_zero(departure.size);
    if (!is_left_out(now)) forecast.learn(now.time, now.reading);
  }
  return past;
}

/// Readings of a gauge that count, until it slips.
std::vector<const statistics::Innovation*> sound_readings(const Learned& learned) {
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
    if (!judging::is_valid(run)) continue;
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
      basis.ensemble.runs(), [](const v1::StudyRun& run) { return !judging::is_valid(run); });
  if (lost > 0)
    to.add_notes(fmt::format("{} of {} runs of the ensemble do not count: they have not ended, "
                             "failed, or left what the model holds for",
                             lost, basis.ensemble.runs_size()));

  for (const std::string& lever : levers_off_plan(basis.plan, basis.readings))
    to.add_notes(lever + (basis.followed_run.empty()
                              ? ": the forecast holds for the plan, and rests on less"
                              : ": the forecast counts what that has done, and rests on less"));

  if (basis.following.ensemble().empty())
    to.add_notes(fmt::format(
        "the plan was not prepared: this is its run, job {}, plus the last difference between "
        "measured and computed curl, with a band by a rule of thumb; before the next casting: dccast "
        "follow --prepare CASE",
        basis.following.plan_job()));
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

  if (basis.levers) add_advice(*basis.levers, basis.following, forecast);
  return forecast;
}

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
    const Eigen::VectorXd& instants = known.prior.trajectory.time;
    curls.push_back(observed(gauge, instants(instants.size() - 1), sound_readings(known.learned)));
  }
  return curls;
}

}  // namespace dccast::studies
