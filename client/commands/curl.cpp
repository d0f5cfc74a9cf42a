#include <iostream>

#include "client/commands/commands.hpp"
#include "client/job_id.hpp"
#include "client/job_result.hpp"
#include "client/message_json.hpp"
#include "client/render/curl_history.hpp"
#include "client/render/findings.hpp"
#include "client/render/table.hpp"
#include "client/render/validity.hpp"
#include "client/study_reading.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/values/interpolation.hpp"

namespace dccast::client::commands {
namespace {

struct Options {
  std::string id;
  bool csv = false;
  bool json = false;
};

using render::CurlHistory;

std::string csv_name(const std::string& name) {
  if (name.find_first_of(",\"\n") == std::string::npos) return name;
  std::string quoted = "\"";
  for (const char c : name) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

/// All data that the command prints for a job.
struct JobCurl {
  v1::Job job;
  CurlHistory history;
  Study study;  ///< empty if the job belongs to none
};

/// Results of the job's study for a monitor at the steps of the job; empty columns without a study.
struct Error {
  std::vector<double> limit_m, uncertainty_m;
};

Error error_of(const CurlHistory& history, const std::string& monitor, const Study& study) {
  const MonitorStudy* said = study.monitor(monitor);
  if (said == nullptr) return {};
  return {values::at_instants(history.time_s, study.time_s, said->limit.value_m),
          values::at_instants(history.time_s, study.time_s, said->limit.uncertainty_m)};
}

/// Columns of the CSV after time and cast length, by name.
std::vector<std::pair<std::string, std::vector<double>>> columns_of(const CurlHistory& history,
                                                                    const Study& study) {
  std::vector<std::pair<std::string, std::vector<double>>> columns;
  for (const auto& series : history.monitors) {
    columns.emplace_back(series.name + "_curl_m", series.curl_m);
    Error error = error_of(history, series.name, study);
    if (error.limit_m.empty()) continue;
    columns.emplace_back(series.name + "_limit_m", std::move(error.limit_m));
    columns.emplace_back(series.name + "_uncertainty_m", std::move(error.uncertainty_m));
  }
  return columns;
}

void print_csv(const JobCurl& curl) {
  const auto& [job, history, study] = curl;
  const auto columns = columns_of(history, study);
  const bool has_limits = !study.monitors.empty();
  std::cout << "time_s,cast_length_m";
  for (const auto& [name, values] : columns) std::cout << ',' << csv_name(name);
  std::cout << ",beyond_validity" << (has_limits ? ",limit_beyond_validity\n" : "\n");
  for (std::size_t i = 0; i < history.time_s.size(); ++i) {
    std::cout << case_file::number_text(history.time_s[i]) << ','
              << case_file::number_text(history.cast_length_m[i]);
    for (const auto& [name, values] : columns)
      std::cout << ',' << case_file::number_text(values[i]);
    std::cout << ',' << history.beyond[i];
    if (has_limits) std::cout << ',' << !study.valid_at(history.time_s[i]);
    std::cout << '\n';
  }
}

void print_json(const JobCurl& curl) {
  const auto& [job, history, study] = curl;
  Json json{{"job", job.id()},
            {"time_s", history.time_s},
            {"cast_length_m", history.cast_length_m},
            {"beyond_validity", history.beyond},
            {"validity_loss", job.has_validity_loss() ? to_json(job.validity_loss()) : Json()}};
  json["findings"] = Json::array();
  for (const v1::Finding& finding : job.findings()) json["findings"].push_back(to_json(finding));
  if (study.valid_until_s) json["limit_valid_until_s"] = *study.valid_until_s;
  json["monitors"] = Json::array();
  for (const auto& series : history.monitors) {
    Json& monitor = json["monitors"].emplace_back(Json{{"name", series.name},
                                                       {"curl_m", series.curl_m},
                                                       {"horizontal_m", series.horizontal_m},
                                                       {"temperature_c", series.temperature_c}});
    const Error error = error_of(history, series.name, study);
    if (error.limit_m.empty()) continue;
    monitor["limit_m"] = error.limit_m;
    monitor["uncertainty_m"] = error.uncertainty_m;
  }
  std::cout << json.dump() << '\n';
}

void print_table(const JobCurl& curl) {
  const CurlHistory& history = curl.history;
  const bool lost = history.first_beyond().has_value();
  std::vector<std::string> headings{">time s", ">cast mm"};
  for (const auto& series : history.monitors) headings.push_back(">" + series.name + " mm");
  if (lost) headings.push_back("validity");
  render::Table table(headings);
  for (std::size_t i = 0; i < history.time_s.size(); ++i) {
    std::vector<std::string> row{render::fixed(history.time_s[i], 2),
                                 render::fixed(1e3 * history.cast_length_m[i], 2)};
    for (const auto& series : history.monitors)
      row.push_back(render::fixed(1e3 * series.curl_m[i], 3));
    if (lost) row.push_back(history.beyond[i] ? render::beyond_validity : "");
    table.add(std::move(row));
  }
  std::cout << table.text() << std::flush;
  for (const v1::Finding& finding : curl.job.findings())
    std::cerr << render::finding_line(finding) << '\n';
  if (curl.job.has_validity_loss())
    std::cerr << render::validity_text(curl.job.validity_loss()) << '\n';
}

JobCurl curl_of_job(const std::string& id, bool with_study, Connection& connection) {
  v1::GetJobRequest request;
  request.set_id(id);
  JobCurl curl;
  curl.job = connection.call(&Stub::GetJob, request);
  const auto result = query_result(connection, id);
  curl.history = render::curl_history(curl.job, result);
  if (with_study) curl.study = study_around(connection, curl.job);
  return curl;
}

ExitCode run(const Options& options, Program& program) {
  Connection connection = program.connect();
  const JobCurl curl =
      curl_of_job(resolve_job(connection, options.id), options.csv || options.json, connection);
  if (options.csv)
    print_csv(curl);
  else if (options.json)
    print_json(curl);
  else
    print_table(curl);
  return ExitCode::done;
}

}  // namespace

void add_curl(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command = subcommand(
      app, "curl",
      "Butt curl (upward displacement) of every monitor, step by step. Of a job that belongs to "
      "a study, CSV and JSON also have the limit of every monitor and its uncertainty. Steps after "
      "the model had stopped being valid are marked",
      "dccast curl JOB\n  dccast curl --csv JOB > curl.csv");
  command->add_option("JOB", options->id, job_help)->required();
  CLI::Option* const csv =
      command->add_flag("--csv", options->csv, "Comma-separated, in metres and seconds");
  command->add_flag("--json", options->json, "As JSON, in metres and seconds")->excludes(csv);
  command->callback([options, &program] {
    program.action = [options, &program] { return run(*options, program); };
  });
}

}  // namespace dccast::client::commands
