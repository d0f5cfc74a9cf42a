#include "server/studies/run_history.hpp"

#include <algorithm>
#include <limits>

namespace dccast::studies {

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

v1::CurlCurve& curve_of(RunHistory& history, const std::string& monitor) {
  for (v1::CurlCurve& curve : history.curves)
    if (curve.monitor() == monitor) return curve;
  history.curves.emplace_back().set_monitor(monitor);
  return history.curves.back();
}

/// A monitor has no value before its first report, and none in a step that leaves it out.
void fill_up(v1::CurlCurve& curve, std::size_t count) {
  while (curve.curl_m_size() < static_cast<int>(count)) curve.add_curl_m(unknown);
}

void add_instants(v1::CurlCurve& curve, const std::vector<v1::StepReport>& steps) {
  for (const v1::StepReport& step : steps) {
    curve.add_time_s(step.time_s());
    curve.add_cast_length_m(step.cast_length_m());
  }
}

std::optional<double> first_beyond(const v1::Job& job, const std::vector<v1::StepReport>& steps) {
  constexpr double margin_s = 1e-9;  // the same time, read from a text
  const auto beyond = [&job](const v1::StepReport& step) {
    return step.beyond_validity() ||
           (job.has_validity_loss() && step.time_s() >= job.validity_loss().time_s() - margin_s);
  };
  const auto first = std::ranges::find_if(steps, beyond);
  if (first == steps.end()) return std::nullopt;
  return first->time_s();
}

}  // namespace

double curl_of(const v1::MonitorValue& monitor) {
  const int coordinates = monitor.displacement_m_size();
  return coordinates > 1 ? monitor.displacement_m(coordinates - 1) : unknown;
}

double curl_at(const v1::StepReport& step, const std::string& monitor) {
  for (const v1::MonitorValue& value : step.monitors())
    if (value.name() == monitor) return curl_of(value);
  return unknown;
}

const v1::CurlCurve* RunHistory::curve(const std::string& monitor) const {
  const auto found = std::ranges::find(curves, monitor, &v1::CurlCurve::monitor);
  return found == curves.end() ? nullptr : &*found;
}

RunHistory run_history(const v1::Job& job, const std::vector<v1::StepReport>& steps) {
  RunHistory history;
  history.beyond_from_s = first_beyond(job, steps);
  for (std::size_t i = 0; i < steps.size(); ++i)
    for (const v1::MonitorValue& value : steps[i].monitors()) {
      v1::CurlCurve& curve = curve_of(history, value.name());
      fill_up(curve, i);
      curve.add_curl_m(curl_of(value));
      if (!value.has_temperature_c()) continue;
      auto& temperature_c = history.temperature_c[value.name()];
      temperature_c.resize(steps.size(), unknown);
      temperature_c[i] = value.temperature_c();
    }
  for (v1::CurlCurve& curve : history.curves) {
    fill_up(curve, steps.size());
    add_instants(curve, steps);
  }
  return history;
}

}  // namespace dccast::studies
