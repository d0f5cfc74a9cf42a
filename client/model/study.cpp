#include "client/model/study.hpp"

#include <cmath>
#include <utility>

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

MonitorStudy monitor_of(const v1::StudyResult::Limit& limit, std::size_t place,
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
        study.monitors.push_back(monitor_of(limit, place, study.levels));
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
  for (const MonitorStudy& monitor : monitors)
    if (monitor.name == name) return &monitor;
  return nullptr;
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

}  // namespace dccast::client
