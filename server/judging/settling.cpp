#include "server/judging/settling.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "core/statistics/curl_trace.hpp"
#include "proto/figures/rounding.hpp"
#include "proto/values/interpolation.hpp"

namespace dccast::judging {
namespace {

constexpr double longest_window_s = statistics::CurlTrace::length, shortest_window_s = 1.0;
constexpr double at_rest_m_per_s = 5e-6;  // without time.settled

/// Mean rates of a curl in the last two windows of equal length.
struct LastRates {
  double window_s;
  double before_m_per_s, last_m_per_s;
};

/// Rates at the last step. @return last_m_per_s is NaN where the curl is not known for so long
LastRates last_rates(const JudgedRun& run, const std::vector<double>& curl_m) {
  const std::vector<double> time_s = run.time_s();
  const double end_s = time_s.back();
  const double window_s = std::min(longest_window_s, 0.5 * end_s);
  const auto at =
      values::at_instants({end_s - 2.0 * window_s, end_s - window_s, end_s}, time_s, curl_m);
  return {window_s, (at[1] - at[0]) / window_s, (at[2] - at[1]) / window_s};
}

/// Whether a run shows how its curl ends: it was followed for a moment and does not cool down.
bool shows_its_end(const JudgedRun& run) {
  return !run.steps.empty() && run.steps.back().time_s() >= 2.0 * shortest_window_s &&
         run.description.time().cool_down_s() <= 0.0;
}

}  // namespace

bool has_settled(const JudgedRun& run) {
  const v1::TimeControl& time = run.description.time();
  if (!time.has_settled_m_per_s() || !shows_its_end(run)) return false;

  statistics::CurlTrace trace;
  for (const v1::StepReport& step : run.steps) {
    const auto* judged = figures::judged_curl(step);
    trace.add(step.time_s(), judged == nullptr ? std::nan("") : figures::curl_of(*judged));
  }
  return trace.has_settled(time.settled_m_per_s(), run.steps.back().cast_length_m());
}

std::string settling_sentence(const JudgedRun& run, const std::vector<double>& curl_m) {
  const v1::TimeControl& time = run.description.time();
  if (!shows_its_end(run)) return {};

  if (has_settled(run))
    return fmt::format("The curl has settled: it moved by less than {:.2g} mm/s.",
                       1e3 * time.settled_m_per_s());

  const LastRates rates = last_rates(run, curl_m);
  const double mm_per_s = 1e3 * rates.last_m_per_s;
  if (!std::isfinite(mm_per_s)) return {};
  if (!time.has_settled_m_per_s() && std::abs(rates.last_m_per_s) < at_rest_m_per_s) return {};

  // A curl that settles does so like exp(-time / decay). Later on it decays more slowly.
  const char* const moves = mm_per_s > 0.0 ? "rises" : "falls";
  const double slower = rates.before_m_per_s / rates.last_m_per_s;
  constexpr double least_slower = 1.1;
  if (!(slower > least_slower))
    return fmt::format(
        "The curl still {} by {:.2g} mm/s at the end: a later time.end shows where it ends.", moves,
        std::abs(mm_per_s));
  const double decay_s = rates.window_s / std::log(slower);
  constexpr double least_whole_m = 9.5e-3;  // shown without decimals
  const double at_end_m_per_s = rates.last_m_per_s * std::exp(-0.5 * rates.window_s / decay_s);
  const double to_come_m = std::abs(at_end_m_per_s) * decay_s;
  return fmt::format(
      "The curl still {} by {:.2g} mm/s at the end: with nothing changed about {} mm or more are "
      "to come.",
      moves, 1e3 * std::abs(at_end_m_per_s),
      figures::mm(to_come_m, to_come_m < least_whole_m ? 1 : 0));
}

}  // namespace dccast::judging
