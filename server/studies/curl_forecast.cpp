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
#include "server/studies/advice.hpp"
#include "server/studies/curl_prior.hpp"
#include "server/studies/levers_off_plan.hpp"

namespace dccast::studies {

namespace {

using statistics::Departure;
using statistics::TrajectoryForecast;

bool is_left_out(const statistics::Innovation& innovation) {
  return std::abs(statistics::normalised(innovation)) > statistics::farthest_innovation;
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
    if (is_left_out(innovations.back())) {
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
  std::vector<statistics::Innovation> innovations;
  std::vector<Departure> departures;  ///< by time
};

/// Learns from all readings of a gauge. Where it has slipped they are learned once more, with a zero
/// that is unknown again from there on; otherwise the slip would be taken for curl.
Learned learned_from(const TrajectoryForecast& prior, const v1::Gauge& gauge,
                     const std::vector<v1::Reading>& readings, v1::ForecastCurl& curl) {
  constexpr std::size_t most_slips = 8;
  std::vector<Departure> slips;
  for (;;) {
    Learned learned{prior, {}, {}};
    learned.innovations = learn(learned.forecast, readings, slips, curl);
    learned.departures = statistics::find_departures(learned.innovations, gauge.noise_m());
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

/// With the band that holds nine of ten.
v1::ExpectedCurl expected_curl(const statistics::Estimated& estimated) {
  const double half = nine_of_ten * estimated.deviation;
  v1::ExpectedCurl curl;
  curl.set_curl_m(estimated.value);
  curl.set_lower_m(estimated.value - half);
  curl.set_upper_m(estimated.value + half);
  return curl;
}

statistics::Gauge gauge_of(const v1::Gauge& gauge) {
  return {.noise = gauge.noise_m(), .zero = gauge.zero_m()};
}

/// Adds what the gauge has shown, evenly thinned.
void add_measured(const std::vector<statistics::Innovation>& innovations, v1::ForecastCurl& to) {
  constexpr std::size_t most = 500;
  const std::size_t stride = innovations.size() / most + 1;
  for (std::size_t i = innovations.empty() ? 0 : (innovations.size() - 1) % stride;
       i < innovations.size(); i += stride) {
    to.add_measured_time_s(innovations[i].time);
    to.add_measured_m(innovations[i].reading);
  }
}

/// Adds the curl at a gauge, its warnings, and why castings on the line do not count.
void add_curl(const v1::Gauge& gauge, const ForecastBasis& basis, v1::Forecast& to) {
  v1::ForecastCurl& curl = *to.add_curls();
  curl.set_monitor(gauge.monitor());
  const CurlPrior prior = prior_of_curl(basis, gauge.monitor());
  curl.set_members(prior.members);
  if (prior.line) *curl.mutable_line() = *prior.line;
  for (const std::string& note : prior.notes) to.add_notes(note);

  const Eigen::VectorXd& instants = prior.trajectory.time;
  const TrajectoryForecast before(prior.trajectory, gauge_of(gauge));
  *curl.mutable_before() = expected_curl(before.at(instants(instants.size() - 1)));

  const Learned learned = learned_from(before, gauge, basis.readings, curl);
  for (const Departure& departure : learned.departures)
    *to.add_warnings() = warning_of(departure, gauge.monitor());

  add_measured(learned.innovations, curl);

  const auto add = [&](double time_s) {
    const v1::ExpectedCurl at = expected_curl(learned.forecast.at(time_s));
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
/// before it. @param forecast  that has learned nothing yet
judging::PastForecast forecast_ahead(TrajectoryForecast forecast, const std::string& monitor,
                                     const Learned& learned, double ahead_s) {
  judging::PastForecast past{.monitor = monitor, .ahead_s = ahead_s};
  const auto add = [&](const statistics::Innovation& reading) {
    const double made_s = reading.time - ahead_s;
    if (made_s < 0.0 || is_left_out(reading)) return;
    if (is_past_slip(learned.departures, made_s, reading.time)) return;

    const v1::ExpectedCurl expected = expected_curl(forecast.expected_reading(reading.time));
    past.time_s.push_back(reading.time);
    past.measured_m.push_back(reading.reading);
    past.expected_m.push_back(expected.curl_m());
    past.lower_m.push_back(expected.lower_m());
    past.upper_m.push_back(expected.upper_m());
  };

  auto to_come = learned.innovations.begin();
  for (const statistics::Innovation& now : learned.innovations) {
    // Those that are due before this reading.
    for (; to_come != learned.innovations.end() && to_come->time - ahead_s < now.time; ++to_come)
      add(*to_come);

    for (const Departure& departure : learned.departures)
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
    const CurlPrior prior = prior_of_curl(basis, gauge.monitor());
    const TrajectoryForecast before(prior.trajectory, gauge_of(gauge));
    v1::ForecastCurl counted;
    counted.set_monitor(gauge.monitor());
    const Learned learned = learned_from(before, gauge, basis.readings, counted);

    for (const double ahead_s : {30.0, 60.0})
      past.push_back(forecast_ahead(before, gauge.monitor(), learned, ahead_s));
  }
  return past;
}

std::vector<v1::ObservedCurl> observed_curls(const ForecastBasis& basis) {
  std::vector<v1::ObservedCurl> curls;
  for (const v1::Gauge& gauge : basis.following.gauges()) {
    const CurlPrior prior = prior_of_curl(basis, gauge.monitor());
    v1::ForecastCurl counted;
    counted.set_monitor(gauge.monitor());
    const Learned learned = learned_from(TrajectoryForecast(prior.trajectory, gauge_of(gauge)), gauge,
                                         basis.readings, counted);
    const double end_s = prior.trajectory.time(prior.trajectory.time.size() - 1);
    curls.push_back(observed(gauge, end_s, sound_readings(learned)));
  }
  return curls;
}

}  // namespace dccast::studies
