#include "server/studies/run_curves.hpp"

#include <cmath>
#include <utility>

#include "proto/figures/run_history.hpp"
#include "proto/values/interpolation.hpp"

namespace dccast::studies {

std::size_t RunCurves::bytes() const {
  std::size_t bytes = least_shell_m.size() * sizeof(double);
  for (const v1::CurlCurve& curve : curves) bytes += curve.SpaceUsedLong();
  for (const auto& [monitor, values] : temperature_c) bytes += values.size() * sizeof(double);
  return bytes;
}

void RunCurves::hold_until(double time_s) {
  constexpr double same_time_s = 1e-6;
  if (curves.empty() || curves.front().time_s().empty() ||
      *curves.front().time_s().rbegin() >= time_s - same_time_s)
    return;

  for (v1::CurlCurve& curve : curves) {
    const int last = curve.time_s_size() - 1;
    const double longer_s = time_s - curve.time_s(last);
    const double speed_m_per_s = last == 0
                                     ? 0.0
                                     : (curve.cast_length_m(last) - curve.cast_length_m(last - 1)) /
                                           (curve.time_s(last) - curve.time_s(last - 1));
    curve.add_time_s(time_s);
    curve.add_cast_length_m(curve.cast_length_m(last) + speed_m_per_s * longer_s);
    curve.add_curl_m(curve.curl_m(last));
  }
  for (auto& [monitor, temperatures] : temperature_c) temperatures.push_back(std::nan(""));
  if (!least_shell_m.empty()) least_shell_m.push_back(least_shell_m.back());
}

std::vector<double> at_instants(const std::vector<double>& instants_s, const v1::CurlCurve& curve,
                                const google::protobuf::RepeatedField<double>& figures) {
  return values::at_instants(instants_s, {curve.time_s().begin(), curve.time_s().end()},
                             {figures.begin(), figures.end()});
}

RunCurves run_curves(const v1::Job& job, std::vector<v1::StepReport> steps) {
  const figures::RunHistory history = figures::run_history(job, std::move(steps));
  const std::vector<double> time_s = history.time_s(), cast_length_m = history.cast_length_m();

  RunCurves curves;
  curves.beyond_from_s = history.beyond_from_s();
  for (const v1::StepReport& step : history.steps)
    curves.least_shell_m.push_back(step.least_shell_m());

  for (const std::string& monitor : history.monitors()) {
    figures::MonitorSeries series = history.series(monitor);
    v1::CurlCurve& curve = curves.curves.emplace_back();
    curve.set_monitor(monitor);
    curve.mutable_time_s()->Add(time_s.begin(), time_s.end());
    curve.mutable_cast_length_m()->Add(cast_length_m.begin(), cast_length_m.end());
    curve.mutable_curl_m()->Add(series.curl_m.begin(), series.curl_m.end());

    const auto is_known = [](double temperature_c) { return std::isfinite(temperature_c); };
    if (std::ranges::any_of(series.temperature_c, is_known))
      curves.temperature_c[monitor] = std::move(series.temperature_c);
  }
  return curves;
}

}  // namespace dccast::studies
