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
