#include "client/study.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include <google/protobuf/util/time_util.h>

namespace dccast::client {
namespace {

/// Coarsest first; of one refinement the one that counts first.
bool before(const StudyLevel& a, const StudyLevel& b) {
  using google::protobuf::util::TimeUtil;
  const auto key = [](const StudyLevel& level) {
    return std::tuple(level.refinement, !level.succeeded(),
                      -TimeUtil::TimestampToMilliseconds(level.job.create_time()));
  };
  return key(a) < key(b);
}

const render::CurlHistory::Series* series_of(const StudyLevel& level, const std::string& name) {
  for (const auto& series : level.history.monitors)
    if (series.name == name) return &series;
  return nullptr;
}

void judge_monitor(Study& study, const std::string& name) {
  MonitorStudy monitor{name, {}, {}};
  std::vector<RefinedCurve> curves;
  for (const StudyLevel* level : study.succeeded()) {
    const auto* series = series_of(*level, name);
    if (series == nullptr) continue;
    monitor.end_curl_m.push_back(series->curl_m.back());
    curves.push_back(
        {level->refinement, at_instants(study.time_s, level->history.time_s, series->curl_m)});
  }
  if (curves.size() < 2) return;
  monitor.limit = extrapolate(study.time_s, curves);
  study.monitors.push_back(std::move(monitor));
}

std::optional<double> earliest_loss(const std::vector<const StudyLevel*>& levels) {
  std::optional<double> earliest_s;
  for (const StudyLevel* level : levels)
    if (const auto first = level->history.first_beyond()) {
      const double lost_s = level->history.time_s[*first];
      if (!earliest_s || lost_s < *earliest_s) earliest_s = lost_s;
    }
  return earliest_s;
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
    if (level.succeeded() && !level.history.time_s.empty()) found.push_back(&level);
  return found;
}

const MonitorStudy* Study::monitor(const std::string& name) const {
  for (const MonitorStudy& monitor : monitors)
    if (monitor.name == name) return &monitor;
  return nullptr;
}

Study study_of(std::string id, std::vector<StudyLevel> runs) {
  std::sort(runs.begin(), runs.end(), before);
  Study study;
  study.id = std::move(id);
  for (StudyLevel& run : runs) {
    if (!study.levels.empty() && study.levels.back().refinement == run.refinement)
      study.others.push_back(run.job);
    else
      study.levels.push_back(std::move(run));
  }
  const auto succeeded = study.succeeded();
  study.valid_until_s = earliest_loss(succeeded);
  if (succeeded.size() < 2) return study;
  study.time_s = succeeded.front()->history.time_s;
  study.cast_length_m = succeeded.front()->history.cast_length_m;
  for (const auto& series : succeeded.front()->history.monitors) judge_monitor(study, series.name);
  return study;
}

}  // namespace dccast::client
