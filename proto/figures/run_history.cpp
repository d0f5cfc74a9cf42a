#include "proto/figures/run_history.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

namespace dccast::figures {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

template <class Figure>
std::vector<Figure> column(const std::vector<v1::StepReport>& steps,
                           Figure (v1::StepReport::*figure)() const) {
  std::vector<Figure> values;
  std::ranges::transform(steps, std::back_inserter(values), figure);
  return values;
}

/// All components of a displacement but the last one; unknown ones without a displacement.
std::vector<double> horizontal_of(const v1::MonitorValue& monitor, std::size_t components) {
  const auto& u = monitor.displacement_m();
  if (u.empty()) return std::vector<double>(components, unknown);
  return {u.begin(), u.end() - 1};
}

}  // namespace

bool MonitorSeries::has_error() const {
  return !upper_error_m.empty() && std::isfinite(upper_error_m.back());
}

void RunHistory::add(const v1::StepReport& step) {
  if (step.step() > 0) rewind(step.step() - 1);
  steps.push_back(step);
}

void RunHistory::rewind(std::int64_t last_step) {
  while (!steps.empty() && (last_step <= 0 || steps.back().step() > last_step)) steps.pop_back();
}

void RunHistory::mark_beyond(double from_s) {
  constexpr double margin_s = 1e-9;  // the same time, read from a text
  for (v1::StepReport& step : steps)
    if (step.time_s() >= from_s - margin_s) step.set_beyond_validity(true);
}

std::vector<double> RunHistory::time_s() const {
  return column(steps, &v1::StepReport::time_s);
}

std::vector<double> RunHistory::cast_length_m() const {
  return column(steps, &v1::StepReport::cast_length_m);
}

std::vector<bool> RunHistory::beyond() const {
  return column(steps, &v1::StepReport::beyond_validity);
}

std::optional<double> RunHistory::beyond_from_s() const {
  const auto first = std::ranges::find_if(steps, &v1::StepReport::beyond_validity);
  return first == steps.end() ? std::nullopt : std::optional(first->time_s());
}

std::vector<std::string> RunHistory::monitors() const {
  std::vector<std::string> names;
  for (const v1::StepReport& step : steps)
    for (const v1::MonitorValue& value : step.monitors())
      if (std::ranges::find(names, value.name()) == names.end()) names.push_back(value.name());
  return names;
}

MonitorSeries RunHistory::series(const std::string& monitor) const {
  MonitorSeries series{.name = monitor};
  std::size_t components = 1;
  for (const v1::StepReport& step : steps)
    if (const int size = monitor_of(step, monitor).displacement_m_size(); size > 0)
      components = static_cast<std::size_t>(size - 1);

  for (const v1::StepReport& step : steps) {
    const v1::MonitorValue& value = monitor_of(step, monitor);
    const bool has_error = value.has_curl_upper_error_m();
    series.curl_m.push_back(curl_of(value));
    series.lower_error_m.push_back(has_error ? value.curl_lower_error_m() : unknown);
    series.upper_error_m.push_back(has_error ? value.curl_upper_error_m() : unknown);
    series.temperature_c.push_back(value.has_temperature_c() ? value.temperature_c() : unknown);
    series.horizontal_m.push_back(horizontal_of(value, components));
  }
  return series;
}

std::vector<double> RunHistory::curl_m(const std::string& monitor) const {
  const std::vector<std::string> names = monitors();
  if (std::ranges::find(names, monitor) == names.end()) return {};

  std::vector<double> curl;
  for (const v1::StepReport& step : steps) curl.push_back(curl_of(monitor_of(step, monitor)));
  return curl;
}

RunHistory run_history(const v1::Job& job, std::vector<v1::StepReport> steps) {
  RunHistory history{std::move(steps)};
  if (job.has_validity_loss()) history.mark_beyond(job.validity_loss().time_s());
  return history;
}

const v1::MonitorValue& monitor_of(const v1::StepReport& step, const std::string& name) {
  const auto found = std::ranges::find(step.monitors(), name, &v1::MonitorValue::name);
  return found == step.monitors().end() ? v1::MonitorValue::default_instance() : *found;
}

double curl_of(const v1::MonitorValue& monitor) {
  return monitor.has_curl_m() ? monitor.curl_m() : unknown;
}

const v1::MonitorValue* judged_curl(const v1::StepReport& step) {
  const auto found = std::ranges::find_if(step.monitors(), &v1::MonitorValue::judged);
  return found == step.monitors().end() ? nullptr : &*found;
}

}  // namespace dccast::figures
