#include "client/text/job_csv.hpp"

#include <google/protobuf/util/time_util.h>

#include <array>
#include <limits>
#include <sstream>
#include <utility>

#include "client/session/jobs.hpp"
#include "client/text/job_text.hpp"
#include "client/text/table.hpp"
#include "proto/case_file/quantity.hpp"

namespace dccast::client {
namespace {

/// Columns of the CSV after time and cast length, by name.
std::vector<std::pair<std::string, std::vector<double>>> columns_of(const JobCurl& curl) {
  std::vector<std::pair<std::string, std::vector<double>>> columns;
  for (const std::string& monitor : curl.history.monitors()) {
    const figures::MonitorSeries series = curl.history.series(monitor);
    columns.emplace_back(series.name + "_curl_m", series.curl_m);
    CurlError error = error_of(curl, series);
    if (!error.limit_m.empty())
      columns.emplace_back(series.name + "_limit_m", std::move(error.limit_m));
    if (error.upper_m.empty()) continue;
    columns.emplace_back(series.name + "_lower_error_m", std::move(error.lower_m));
    columns.emplace_back(series.name + "_upper_error_m", std::move(error.upper_m));
  }
  return columns;
}

/// "2026-11-20T08:15:30Z"; empty where there is no time.
std::string iso_text(const google::protobuf::Timestamp& time) {
  return time.seconds() == 0 ? "" : google::protobuf::util::TimeUtil::ToString(time);
}

/// See sound_curl() [m]; empty where there is none.
std::string last_curl(const v1::Job& job) {
  const v1::MonitorValue* const judged = sound_curl(job);
  return judged == nullptr ? "" : case_file::number_text(figures::curl_of(*judged));
}

}  // namespace

JobCurl curl_of_job(Connection& connection, const std::string& id) {
  JobCurl curl{connection.call(&Stub::GetJob, id), {}, {}};
  curl.history = run_history(curl.job, query_result(connection, id));
  return curl;
}

CurlError error_of(const JobCurl& curl, const figures::MonitorSeries& series) {
  const auto& [job, history, study] = curl;
  if (auto limit = limit_at(history.time_s(), study, series.name))
    return {std::move(limit->value_m), limit->uncertainty_m, limit->uncertainty_m};

  if (!series.has_error()) return {};
  return {{}, series.lower_error_m, series.upper_error_m};
}

std::string curl_csv(const JobCurl& curl) {
  const auto& [job, history, study] = curl;
  const auto columns = columns_of(curl);
  // The limit is valid as long as every run is from which it is extrapolated.
  const bool has_limits = !study.limits().empty();
  const double valid_until_s =
      study.has_valid_until_s() ? study.valid_until_s() : std::numeric_limits<double>::infinity();
  std::ostringstream csv;
  csv << "time_s,cast_length_m";
  for (const auto& [name, values] : columns) csv << ',' << csv_text(name);
  csv << ",beyond_validity" << (has_limits ? ",limit_beyond_validity\n" : "\n");
  for (std::size_t i = 0; i < history.steps.size(); ++i) {
    const v1::StepReport& step = history.steps[i];
    csv << case_file::number_text(step.time_s()) << ','
        << case_file::number_text(step.cast_length_m());
    for (const auto& [name, values] : columns) csv << ',' << case_file::number_text(values[i]);
    csv << ',' << step.beyond_validity();
    if (has_limits) csv << ',' << (step.time_s() >= valid_until_s);
    csv << '\n';
  }
  return csv.str();
}

std::string jobs_csv(const std::vector<v1::Job>& jobs) {
  struct Column {
    const char* name;
    std::string (*cell)(const v1::Job&);
  };
  using case_file::number_text;
  static const std::array columns{
      Column{"id", [](const auto& job) { return job.id(); }},
      Column{"title", [](const auto& job) { return csv_text(job.title()); }},
      Column{"state", [](const auto& job) { return v1::JobState_Name(job.state()); }},
      Column{"owner", [](const auto& job) { return csv_text(job.owner()); }},
      Column{"priority", [](const auto& job) { return v1::Priority_Name(job.priority()); }},
      Column{"created", [](const auto& job) { return iso_text(job.create_time()); }},
      Column{"started", [](const auto& job) { return iso_text(job.start_time()); }},
      Column{"ended", [](const auto& job) { return iso_text(job.end_time()); }},
      Column{"labels", [](const auto& job) { return csv_text(joined(job.labels(), "; ")); }},
      Column{"study", [](const auto& job) { return job.study(); }},
      Column{"quality", [](const auto& job) { return csv_text(job.quality()); }},
      Column{"time_s", [](const auto& job) { return number_text(job.last_step().time_s()); }},
      Column{"cast_length_m",
             [](const auto& job) { return number_text(job.last_step().cast_length_m()); }},
      Column{"curl_m", last_curl},
      Column{"findings",
             [](const auto& job) { return joined(job.findings(), " ", &v1::Finding::code); }},
  };

  std::string csv = joined(columns, ",", &Column::name) + "\n";
  for (const v1::Job& job : jobs)
    csv += joined(columns, ",", [&](const Column& column) { return column.cell(job); }) + "\n";
  return csv;
}

}  // namespace dccast::client
