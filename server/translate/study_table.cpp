// The runs of a study as the table of docs/studies.md.
#include <algorithm>
#include <cctype>
#include <limits>

#include "server/translate/translate.hpp"

namespace dccast::translate {

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// "SUCCEEDED" as "succeeded"; "STUDY_FAILED" as "failed".
std::string lower(std::string name) {
  const std::string prefix = "STUDY_";
  if (name.starts_with(prefix)) name.erase(0, prefix.size());
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  return name;
}

/// Entry `index` of a field that may be shorter than the table's row.
template <class Field>
double value_or_unknown(const Field& field, int index) {
  return index < field.size() ? field.Get(index) : unknown;
}

/// The larger side of the band.
double relative_curl_error(const v1::StudyRun& run) {
  if (!run.has_mesh_error()) return unknown;
  return std::max(run.mesh_error().lower(), run.mesh_error().upper());
}

void add_runs(const v1::StudyResult& result, std::vector<results::FileColumn>& columns) {
  const auto add = [&](const char* object, const char* unit, const char* meaning, auto figure) {
    std::vector<decltype(figure(v1::StudyRun()))> values;
    for (const v1::StudyRun& run : result.runs()) values.push_back(figure(run));
    columns.push_back({object, unit, meaning, std::move(values)});
  };
  // (run, `width`): one figure of each key or monitor
  const auto add_matrix = [&](const char* object, const char* unit, const char* meaning, int width,
                              auto figure) {
    std::vector<decltype(figure(v1::StudyRun(), 0))> values;
    for (const v1::StudyRun& run : result.runs())
      for (int i = 0; i < width; ++i) values.push_back(figure(run, i));
    const std::vector<std::size_t> shape{std::size_t(result.runs_size()), std::size_t(width)};
    columns.push_back({object, unit, meaning, std::move(values), shape});
  };
  using Run = v1::StudyRun;
  const int keys = result.study().sweep().axes_size();

  add("/runs/job", nullptr, "UUID of the job of each run",
      [](const Run& run) { return run.job(); });
  add("/runs/state", nullptr, "state of each run",
      [](const Run& run) { return lower(v1::JobState_Name(run.state())); });
  add_matrix("/runs/value", nullptr, "value of each key, as written", keys,
             [](const Run& run, int i) { return i < run.values_size() ? run.values(i) : ""; });
  add_matrix("/runs/number", "SI", "the same as numbers", keys,
             [](const Run& run, int i) { return value_or_unknown(run.numbers(), i); });

  add_matrix("/runs/end_curl_m", "m", "curl at the end", result.monitors_size(),
             [](const Run& run, int i) { return value_or_unknown(run.end_curl_m(), i); });
  add("/runs/relative_curl_error", "1", "discretisation error of a curl, relative to the curl",
      relative_curl_error);
  add("/runs/solver_s", "s", "processor time of the solver",
      [](const Run& run) { return run.solver_s(); });
  add("/runs/refinement", "1", "of a refinement study",
      [](const Run& run) { return run.refinement(); });

  add("/runs/beyond_validity", "1", "1: beyond validity, the curl is not valid",
      [](const Run& run) { return std::int32_t(run.beyond_validity()); });
  add("/runs/failure", nullptr, "why a run failed",
      [](const Run& run) { return run.failure().message(); });
}

/// All monitors of a run share the instants of its first curve.
void add_curves(const v1::StudyResult& result, std::vector<results::FileColumn>& columns) {
  std::vector<std::int64_t> start{0};
  std::vector<double> time, cast_length, curl;
  for (const v1::StudyRun& run : result.runs()) {
    const int samples = run.curves_size() > 0 ? run.curves(0).time_s_size() : 0;
    for (int i = 0; i < samples; ++i) {
      time.push_back(run.curves(0).time_s(i));
      cast_length.push_back(value_or_unknown(run.curves(0).cast_length_m(), i));
      for (const std::string& monitor : result.monitors()) {
        const auto curve = std::ranges::find(run.curves(), monitor, &v1::CurlCurve::monitor);
        curl.push_back(curve == run.curves().end() ? unknown
                                                   : value_or_unknown(curve->curl_m(), i));
      }
    }
    start.push_back(static_cast<std::int64_t>(time.size()));
  }

  const std::vector<std::size_t> shape{time.size(), std::size_t(result.monitors_size())};
  columns.push_back(
      {"/curves/start", "1", "first sample of each run, and the number of samples", start});
  columns.push_back({"/curves/time_s", "s", "of each sample", time});
  columns.push_back({"/curves/cast_length_m", "m", "of each sample", cast_length});
  columns.push_back({"/curves/curl_m", "m", "curl of each monitor", curl, shape});
}

void add_findings(const v1::StudyResult& result, std::vector<results::FileColumn>& columns) {
  std::vector<std::int32_t> number;
  std::vector<std::string> code, severity;
  std::vector<double> time;
  for (int run = 0; run < result.runs_size(); ++run)
    for (const v1::Finding& finding : result.runs(run).findings()) {
      number.push_back(run);
      code.push_back(finding.code());
      severity.push_back(lower(v1::Finding::Severity_Name(finding.severity())));
      time.push_back(finding.has_time_s() ? finding.time_s() : unknown);
    }

  columns.push_back({"/findings/run", "1", "number of its run, from 0", number});
  columns.push_back({"/findings/code", nullptr, "docs/findings.md", code});
  columns.push_back({"/findings/severity", nullptr, "note, warning or danger", severity});
  columns.push_back({"/findings/time_s", "s", "when first seen", time});
}

}  // namespace

results::ColumnFile to_table(const v1::StudyResult& result) {
  constexpr std::int64_t schema_version = 1;
  results::ColumnFile table;
  table.attributes = {{"schema_version", schema_version},
                      {"program", "dccast"},
                      {"program_version", DCCAST_VERSION},
                      {"study", result.study().id()},
                      {"title", result.study().title()},
                      {"state", lower(v1::StudyState_Name(result.study().state()))}};

  std::vector<std::string> keys;
  for (const auto& axis : result.study().sweep().axes()) keys.push_back(axis.key());
  table.columns.push_back({"/key", nullptr, "keys of the case that the sweep changes", keys});
  table.columns.push_back(
      {"/monitor", nullptr, "names of the monitors",
       std::vector<std::string>(result.monitors().begin(), result.monitors().end())});

  add_runs(result, table.columns);
  add_curves(result, table.columns);
  add_findings(result, table.columns);
  return table;
}

}  // namespace dccast::translate
