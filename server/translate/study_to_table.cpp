#include "server/translate/study_to_table.hpp"

#include <algorithm>
#include <limits>

namespace dccast::translate {

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// "SUCCEEDED" as "succeeded"; "STUDY_FAILED" as "failed".
std::string lower(std::string name) {
  const std::string prefix = "STUDY_";
  if (name.starts_with(prefix)) name.erase(0, prefix.size());
  std::ranges::transform(name, name.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return name;
}

/// Entry `index` of a field that may be shorter than the table's row.
template <class Field>
double number_at(const Field& field, int index) {
  return index < field.size() ? field.Get(index) : unknown;
}

const v1::CurlCurve* curve_of(const v1::StudyRun& run, const std::string& monitor) {
  const auto found = std::ranges::find(run.curves(), monitor, &v1::CurlCurve::monitor);
  return found == run.curves().end() ? nullptr : &*found;
}

void add_values(const v1::StudyRun& run, results::StudyTable& table) {
  for (int i = 0; i < static_cast<int>(table.key.size()); ++i) {
    table.value.push_back(i < run.values_size() ? run.values(i) : "");
    table.number.push_back(number_at(run.numbers(), i));
  }
  for (int i = 0; i < static_cast<int>(table.monitor.size()); ++i)
    table.end_curl.push_back(number_at(run.end_curl_m(), i));
}

void add_curve(const v1::StudyRun& run, results::StudyTable& table) {
  const int samples = run.curves_size() > 0 ? run.curves(0).time_s_size() : 0;
  for (int i = 0; i < samples; ++i) {
    table.time.push_back(run.curves(0).time_s(i));
    table.cast_length.push_back(number_at(run.curves(0).cast_length_m(), i));
    for (const std::string& monitor : table.monitor) {
      const v1::CurlCurve* const curve = curve_of(run, monitor);
      table.curl.push_back(curve ? number_at(curve->curl_m(), i) : unknown);
    }
  }
  table.curve_start.push_back(static_cast<std::int64_t>(table.time.size()));
}

void add_findings(const v1::StudyRun& run, results::StudyTable& table) {
  for (const v1::Finding& finding : run.findings()) {
    table.finding_run.push_back(static_cast<std::int32_t>(table.runs()));
    table.finding_code.push_back(finding.code());
    table.finding_severity.push_back(lower(v1::Finding::Severity_Name(finding.severity())));
    table.finding_time.push_back(finding.has_time_s() ? finding.time_s() : unknown);
  }
}

void add_run(const v1::StudyRun& run, results::StudyTable& table) {
  add_findings(run, table);  // counts the runs before this one
  add_values(run, table);
  add_curve(run, table);
  table.job.push_back(run.job());
  table.run_state.push_back(lower(v1::JobState_Name(run.state())));
  table.solver_seconds.push_back(run.solver_s());
  table.refinement.push_back(run.refinement());
  table.beyond_validity.push_back(run.beyond_validity() ? 1 : 0);
  table.failure.push_back(run.failure().message());
}

}  // namespace

results::StudyTable to_table(const v1::StudyResult& result) {
  results::StudyTable table;
  table.program_version = DCCAST_VERSION;
  table.study = result.study().id();
  table.title = result.study().title();
  table.state = lower(v1::StudyState_Name(result.study().state()));
  for (const auto& axis : result.study().sweep().axes()) table.key.push_back(axis.key());
  table.monitor = {result.monitors().begin(), result.monitors().end()};
  table.curve_start.push_back(0);
  for (const v1::StudyRun& run : result.runs()) add_run(run, table);
  return table;
}

}  // namespace dccast::translate
