#include "client/model/answer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "proto/case_file/override.hpp"
#include "proto/values/interpolation.hpp"

namespace dccast::client {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// All components but the last one.
std::vector<double> horizontal_of(const v1::MonitorValue& monitor) {
  const auto& u = monitor.displacement_m();
  if (u.empty()) return {unknown};
  return {u.begin(), u.end() - 1};
}

/// To as many instants, those not reported unknown.
void resize(CurlHistory::Series& series, std::size_t instants) {
  for (auto* values :
       {&series.curl_m, &series.lower_error_m, &series.upper_error_m, &series.temperature_c})
    values->resize(instants, unknown);
  const std::size_t components = series.horizontal_m.empty() ? 1 : series.horizontal_m[0].size();
  series.horizontal_m.resize(instants, std::vector<double>(components, unknown));
}

}  // namespace

double curl_of(const v1::MonitorValue& monitor) {
  return monitor.has_curl_m() ? monitor.curl_m() : unknown;
}

void CurlHistory::add(const v1::StepReport& report) {
  // A run that was resumed from its checkpoint reports some steps again.
  if (report.step() > 0) rewind(report.step() - 1);
  step.push_back(report.step());
  time_s.push_back(report.time_s());
  cast_length_m.push_back(report.cast_length_m());
  beyond.push_back(report.beyond_validity());
  reports.push_back(report);

  for (const v1::MonitorValue& value : report.monitors()) {
    auto found = std::ranges::find(monitors, value.name(), &Series::name);
    if (found == monitors.end()) found = monitors.insert(monitors.end(), {.name = value.name()});
    // A monitor that appears later has no values before.
    resize(*found, time_s.size() - 1);
    found->curl_m.push_back(curl_of(value));
    const bool has_error = value.has_curl_upper_error_m();
    found->lower_error_m.push_back(has_error ? value.curl_lower_error_m() : unknown);
    found->upper_error_m.push_back(has_error ? value.curl_upper_error_m() : unknown);
    found->horizontal_m.push_back(horizontal_of(value));
    found->temperature_c.push_back(value.has_temperature_c() ? value.temperature_c() : unknown);
  }
  for (Series& series : monitors) resize(series, time_s.size());
}

void CurlHistory::rewind(std::int64_t last_step) {
  while (!step.empty() && (last_step <= 0 || step.back() > last_step)) {
    step.pop_back();
    time_s.pop_back();
    cast_length_m.pop_back();
    beyond.pop_back();
    reports.pop_back();
    for (Series& series : monitors) resize(series, time_s.size());
  }
}

void CurlHistory::mark_beyond(double from_s) {
  constexpr double margin_s = 1e-9;  // the same time, read from a text
  for (std::size_t i = 0; i < time_s.size(); ++i)
    if (time_s[i] >= from_s - margin_s) beyond[i] = true;
}

std::optional<std::size_t> CurlHistory::first_beyond() const {
  const auto found = std::ranges::find(beyond, true);
  if (found == beyond.end()) return std::nullopt;
  return static_cast<std::size_t>(found - beyond.begin());
}

CurlHistory curl_history(const v1::Job& job, const v1::QueryResultResponse& result) {
  CurlHistory history;
  for (const v1::StepReport& step : result.steps()) history.add(step);
  if (job.has_validity_loss()) history.mark_beyond(job.validity_loss().time_s());
  return history;
}

const CurlHistory::Series* CurlHistory::largest() const {
  const Series* best = nullptr;
  for (const Series& series : monitors)
    if (!series.curl_m.empty() && std::isfinite(series.curl_m.back()) &&
        (best == nullptr || std::abs(series.curl_m.back()) > std::abs(best->curl_m.back())))
      best = &series;
  return best;
}

std::optional<CurlLimit> limit_at(const std::vector<double>& instants_s,
                                  const v1::StudyResult& study, const std::string& monitor) {
  const auto found = std::ranges::find(
      study.limits(), monitor,
      [](const v1::StudyResult::Limit& limit) { return limit.curve().monitor(); });
  if (found == study.limits().end()) return std::nullopt;

  const v1::CurlCurve& curve = found->curve();
  const auto at = [&](const google::protobuf::RepeatedField<double>& figures) {
    return values::at_instants(instants_s, {curve.time_s().begin(), curve.time_s().end()},
                               {figures.begin(), figures.end()});
  };
  return CurlLimit{at(curve.curl_m()), at(curve.uncertainty_m()), found->has_order()};
}

std::vector<v1::CaseChange> changes_of(const std::vector<std::string>& texts) {
  std::vector<v1::CaseChange> changes;
  for (const std::string& text : texts)
    if (auto change = case_file::parse_change(text)) changes.push_back(std::move(*change));
  return changes;
}

}  // namespace dccast::client
