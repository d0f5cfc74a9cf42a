#include "client/model/effects.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "proto/case_file/quantity.hpp"

namespace dccast::client {
namespace {

bool is_valid(const v1::StudyRun& run, int monitor) {
  return run.state() == v1::SUCCEEDED && !run.beyond_validity() &&
         monitor < run.end_curl_m_size() && std::isfinite(run.end_curl_m(monitor));
}

std::string failure_of_run(const v1::StudyRun& run) {
  if (run.beyond_validity()) return "beyond validity";
  if (run.has_failure()) return run.failure().message();
  return v1::JobState_Name(run.state());
}

/// The axis that a run moves, -1 for the case itself.
int moved_axis(const v1::StudyRun& run) {
  for (int axis = 0; axis < run.values_size(); ++axis)
    if (!run.values(axis).empty()) return axis;
  return -1;
}

}  // namespace

double leading_number(const std::string& text) {
  return std::strtod(text.c_str(), nullptr);
}

std::string rounded(const std::string& text) {
  constexpr double digits = 4.0;
  const double number = leading_number(text);
  if (!(std::abs(number) > 0.0) || !std::isfinite(number)) return text;
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(number))) + 1.0 - digits);
  const auto blank = std::min(text.find(' '), text.size());
  // Divided by a power of ten where it is below 1, so that 0.93 is not 0.93000000000000005.
  const double steps = std::round(number / unit);
  const double value = unit < 1.0 ? steps / std::round(1.0 / unit) : steps * std::round(unit);
  return case_file::number_text(value) + text.substr(blank);
}

double Effect::largest_m() const {
  return std::max(std::abs(low_m.value_or(0.0)), std::abs(high_m.value_or(0.0)));
}

Effects effects_of(const v1::StudyResult& result, int monitor, std::optional<double> of_curl) {
  const auto& axes = result.study().sweep().axes();
  Effects all;
  all.effects.resize(static_cast<std::size_t>(axes.size()));
  for (const v1::StudyRun& run : result.runs())
    if (moved_axis(run) < 0 && is_valid(run, monitor)) all.base_m = run.end_curl_m(monitor);
  for (int axis = 0; axis < axes.size(); ++axis)
    all.effects[static_cast<std::size_t>(axis)].axis = axis;
  for (const v1::StudyRun& run : result.runs()) {
    const int axis = moved_axis(run);
    if (axis < 0) continue;
    Effect& effect = all.effects[static_cast<std::size_t>(axis)];
    const bool low = run.values(axis) == axes[axis].values(0);
    if (all.base_m && is_valid(run, monitor))
      (low ? effect.low_m : effect.high_m) = run.end_curl_m(monitor) - *all.base_m;
    else
      (low ? effect.low_failure : effect.high_failure) = failure_of_run(run);
  }
  std::ranges::stable_sort(all.effects, std::ranges::greater(), &Effect::largest_m);
  if (of_curl && all.base_m) all.error_m = *of_curl * std::abs(*all.base_m);
  return all;
}

int monitor_of(const v1::StudyResult& result, const std::string& name) {
  if (!name.empty()) {
    const auto found = std::ranges::find(result.monitors(), name);
    return found == result.monitors().end() ? -1
                                            : static_cast<int>(found - result.monitors().begin());
  }
  int best = result.monitors().empty() ? -1 : 0;
  double most = -1.0;
  for (const v1::StudyRun& run : result.runs())
    for (int m = 0; m < run.end_curl_m_size(); ++m)
      if (std::abs(run.end_curl_m(m)) > most) {
        most = std::abs(run.end_curl_m(m));
        best = m;
      }
  return best;
}

std::string range_of(const v1::SweepPlan::Axis& axis) {
  if (axis.values_size() != 2) return {};
  const std::string &low = axis.values(0), &high = axis.values(1);
  const double from = leading_number(low), to = leading_number(high);
  constexpr double margin = 1e-9;
  if (axis.key().ends_with(".scale")) {
    if (std::abs(from + to - 2.0) > margin) return low + ".." + high + " times";
    return "± " + case_file::number_text(std::round(1e6 * (to - 1.0)) / 1e4) + " %";
  }
  const bool by_difference = axis.key().ends_with(".offset") || axis.key().ends_with(".shift");
  if (by_difference && std::abs(from + to) < margin) return "± " + high;
  const auto unit = high.find(' ');
  if (unit != std::string::npos && low.ends_with(high.substr(unit)))
    return low.substr(0, low.size() - (high.size() - unit)) + ".." + high;
  return low + ".." + high;
}

std::string RunCount::text() const {
  std::string all = std::to_string(valid) + " valid";
  if (beyond > 0) all += ", " + std::to_string(beyond) + " beyond validity";
  if (failed > 0) all += ", " + std::to_string(failed) + " failed or cancelled";
  if (open > 0) all += ", " + std::to_string(open) + " to come";
  return all;
}

RunCount count_runs(const v1::StudyResult& result) {
  RunCount count;
  for (const v1::StudyRun& run : result.runs()) {
    if (run.state() == v1::FAILED || run.state() == v1::CANCELLED)
      ++count.failed;
    else if (run.state() != v1::SUCCEEDED)
      ++count.open;
    else
      ++(run.beyond_validity() ? count.beyond : count.valid);
  }
  return count;
}

}  // namespace dccast::client
