#include "server/studies/curl_forecast.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "server/judging/judged_study.hpp"
#include "server/levers/lever_watch.hpp"
#include "server/levers/levers_off_plan.hpp"
#include "server/studies/advice.hpp"
#include "server/studies/known_curl.hpp"

namespace dccast::studies {

namespace {

using statistics::Departure;

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

  warning.set_text(
      fmt::format("the measured curl is {:.1f} mm {} what plan and data permit, on "
                  "average since {:.0f} s",
                  mm, departure.size > 0.0 ? "above" : "below", departure.begin));
  // In the order of their usual size.
  for (const char* cause : {"water", "metal temperature", "casting speed"})
    warning.add_causes(cause);
  return warning;
}

v1::ForecastWarning warning_of(const WrongGauge& wrong, const std::string& monitor) {
  v1::ForecastWarning warning;
  warning.set_time_s(wrong.time_s);
  warning.set_monitor(monitor);
  warning.set_text(fmt::format(
      "the gauge shows {:.1f} mm where {:.1f} mm was expected before the casting; no reading of it "
      "counts",
      1e3 * wrong.shown_m, 1e3 * wrong.expected_m));
  warning.add_causes("the unit, scale or sign of the gauge: " + wrong.mistake);
  return warning;
}

/// A warning where most readings of a gauge are left out, from the first time on; empty: they are
/// not.
std::optional<v1::ForecastWarning> warning_of_left_out(
    const std::vector<statistics::Innovation>& innovations, const std::string& monitor) {
  constexpr std::ptrdiff_t fewest = 10;  // readings that tell
  std::ptrdiff_t left_out = 0, count = 0;
  for (const statistics::Innovation& innovation : innovations) {
    ++count;
    if (is_left_out(innovation)) ++left_out;
    if (count < fewest || 2 * left_out <= count) continue;

    v1::ForecastWarning warning;
    warning.set_time_s(innovation.time);
    warning.set_monitor(monitor);
    warning.set_text(
        fmt::format("most readings of this gauge are left out: {} of {} lie too far from what was "
                    "expected, the last one {:.1f} mm",
                    left_out, count, 1e3 * (innovation.reading - innovation.expected.value)));
    warning.add_causes("the gauge");
    return warning;
  }
  return std::nullopt;
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

/// Adds the curl at a gauge from the last reading to the end of the plan.
void add_trajectory(const KnownCurl& known, double last_s, v1::ForecastCurl& to) {
  const auto add = [&](double time_s) {
    const statistics::Estimated as_planned = known.learned().forecast.at(time_s);
    const v1::ExpectedCurl at = expected_curl(known.with_levers(as_planned, time_s, last_s));
    to.add_time_s(time_s);
    to.add_curl_m(at.curl_m());
    to.add_lower_m(at.lower_m());
    to.add_upper_m(at.upper_m());
  };

  const double begin_s = std::max(last_s, 0.0);
  add(begin_s);
  for (const double time_s : known.prior().trajectory.time)
    if (time_s > begin_s) add(time_s);
}

/// Adds the curl at a gauge, its warnings, and why castings on the line do not count.
void add_curl(const v1::Gauge& gauge, const ForecastBasis& basis, v1::Forecast& to) {
  const KnownCurl known(gauge, basis);
  const LearnedCurl& learned = known.learned();

  v1::ForecastCurl& curl = *to.add_curls();
  curl.set_monitor(known.monitor());
  curl.set_members(known.prior().members);
  if (known.prior().line) *curl.mutable_line() = *known.prior().line;
  for (const std::string& note : known.prior().notes) to.add_notes(note);

  const auto left_out = std::ranges::count_if(learned.innovations, is_left_out);
  curl.set_readings(static_cast<int>(std::ssize(learned.innovations) - left_out));
  curl.set_left_out(static_cast<int>(std::ssize(known.readings())) - curl.readings());
  add_measured(known.readings(), curl);
  for (const Departure& departure : learned.departures)
    *to.add_warnings() = warning_of(departure, known.monitor());
  if (known.wrong_gauge()) *to.add_warnings() = warning_of(*known.wrong_gauge(), known.monitor());
  if (auto warning = warning_of_left_out(learned.innovations, known.monitor()))
    *to.add_warnings() = std::move(*warning);

  const Eigen::VectorXd& instants = known.prior().trajectory.time;
  *curl.mutable_before() = expected_curl(known.before().at(instants(instants.size() - 1)));
  add_trajectory(known, to.time_s(), curl);

  const v1::ExpectedCurl zero = expected_curl(learned.forecast.zero());
  curl.set_zero_m(zero.curl_m());
  curl.set_zero_lower_m(zero.lower_m());
  curl.set_zero_upper_m(zero.upper_m());
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
    to.add_notes(
        fmt::format("{} of {} runs of the ensemble do not count: they have not ended, "
                    "failed, or left what the model holds for",
                    lost, basis.ensemble.runs_size()));

  for (const std::string& lever : levers::levers_off_plan(basis.plan, basis.readings))
    to.add_notes(lever + (basis.followed_run.empty()
                              ? ": the forecast holds for the plan, and rests on less"
                              : ": the forecast counts what that has done, and rests on less"));

  if (basis.following.ensemble().empty())
    to.add_notes(fmt::format(
        "the plan was not prepared: this is its run, job {}, plus the last difference between "
        "measured and computed curl, with a band by a rule of thumb; before the next casting: "
        "dccast "
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

  levers::LeverWatch watch(basis.plan);
  for (const v1::Reading& reading : basis.readings) watch.follow(reading);
  // What the other levers would do was computed for a casting as planned.
  if (const auto alarms = watch.under_way(); !alarms.empty())
    forecast.add_advice(watch.remedy_at(forecast.time_s()));
  else if (basis.levers)
    add_advice(*basis.levers, basis.following, forecast);
  return forecast;
}

}  // namespace dccast::studies
