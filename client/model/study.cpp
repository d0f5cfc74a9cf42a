#include "client/model/study.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <utility>

#include "proto/case_file/quantity.hpp"

namespace dccast::client {
namespace {

std::vector<double> values_of(const google::protobuf::RepeatedField<double>& field) {
  return {field.begin(), field.end()};
}

StudyLevel level_of(const v1::StudyRun& run, std::map<std::string, v1::Job>& jobs) {
  StudyLevel level;
  level.refinement = run.refinement();
  level.end_curl_m = values_of(run.end_curl_m());
  level.job.set_state(run.state());
  if (run.has_failure()) *level.job.mutable_failure() = run.failure();
  if (const auto job = jobs.find(run.job()); job != jobs.end()) {
    level.job = std::move(job->second);
    jobs.erase(job);
  }
  return level;
}

MonitorStudy limit_of(const v1::StudyResult::Limit& limit, std::size_t place,
                      const std::vector<StudyLevel>& levels) {
  MonitorStudy monitor;
  monitor.name = limit.curve().monitor();
  if (limit.has_order()) monitor.limit.order = limit.order();
  monitor.limit.value_m = values_of(limit.curve().curl_m());
  monitor.limit.uncertainty_m = values_of(limit.curve().uncertainty_m());
  for (const StudyLevel& level : levels)
    if (level.succeeded() && place < level.end_curl_m.size())
      monitor.end_curl_m.push_back(level.end_curl_m[place]);
  return monitor;
}

void add_limits(const v1::StudyResult& result, Study& study) {
  for (const v1::StudyResult::Limit& limit : result.limits())
    for (std::size_t place = 0; place < study.monitor_names.size(); ++place)
      if (study.monitor_names[place] == limit.curve().monitor())
        study.monitors.push_back(limit_of(limit, place, study.levels));
  if (result.limits().empty()) return;
  study.time_s = values_of(result.limits(0).curve().time_s());
  study.cast_length_m = values_of(result.limits(0).curve().cast_length_m());
}

}  // namespace

std::size_t MonitorStudy::least_certain() const {
  std::size_t at = 0;
  for (std::size_t i = 1; i < limit.uncertainty_m.size(); ++i)
    if (!(limit.uncertainty_m[i] <= limit.uncertainty_m[at]) &&
        std::isfinite(limit.uncertainty_m[i]))
      at = i;
  return at;
}

std::vector<const StudyLevel*> Study::succeeded() const {
  std::vector<const StudyLevel*> found;
  for (const StudyLevel& level : levels)
    if (level.succeeded()) found.push_back(&level);
  return found;
}

const MonitorStudy* Study::monitor(const std::string& name) const {
  const auto found = std::ranges::find(monitors, name, &MonitorStudy::name);
  return found == monitors.end() ? nullptr : &*found;
}

Study study_of(const v1::StudyResult& result, const std::vector<v1::Job>& jobs) {
  std::map<std::string, v1::Job> by_id;
  for (const v1::Job& job : jobs) by_id[job.id()] = job;
  Study study;
  study.id = result.study().id();
  study.monitor_names = {result.monitors().begin(), result.monitors().end()};
  for (const v1::StudyRun& run : result.runs()) study.levels.push_back(level_of(run, by_id));
  for (auto& [id, job] : by_id) study.others.push_back(std::move(job));
  if (result.has_valid_until_s()) study.valid_until_s = result.valid_until_s();
  add_limits(result, study);
  return study;
}

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
