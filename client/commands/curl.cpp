#include <iostream>

#include "client/commands/commands.hpp"
#include "client/message_json.hpp"
#include "client/render/curl_history.hpp"
#include "client/render/table.hpp"
#include "client/study_reading.hpp"
#include "proto/case_file/quantity.hpp"

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

/// What the job's study says of a monitor at the job's own steps; empty columns without one.
struct Error {
  std::vector<double> limit_m, uncertainty_m;
};

Error error_of(const CurlHistory& history, const std::string& monitor, const Study& study) {
  const MonitorStudy* said = study.monitor(monitor);
  if (said == nullptr) return {};
  return {at_instants(history.time_s, study.time_s, said->limit.value_m),
          at_instants(history.time_s, study.time_s, said->limit.uncertainty_m)};
}

/// Columns of the CSV behind time and cast length, by name.
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

void print_csv(const CurlHistory& history, const Study& study) {
  const auto columns = columns_of(history, study);
  std::cout << "time_s,cast_length_m";
  for (const auto& [name, values] : columns) std::cout << ',' << csv_name(name);
  std::cout << '\n';
  for (std::size_t i = 0; i < history.time_s.size(); ++i) {
    std::cout << case_file::number_text(history.time_s[i]) << ','
              << case_file::number_text(history.cast_length_m[i]);
    for (const auto& [name, values] : columns)
      std::cout << ',' << case_file::number_text(values[i]);
    std::cout << '\n';
  }
}

void print_json(const std::string& id, const CurlHistory& history, const Study& study) {
  Json json{{"job", id}, {"time_s", history.time_s}, {"cast_length_m", history.cast_length_m}};
  json["monitors"] = Json::array();
  for (const auto& series : history.monitors) {
    Json& monitor = json["monitors"].emplace_back(Json{
        {"name", series.name}, {"curl_m", series.curl_m}, {"horizontal_m", series.horizontal_m}});
    const Error error = error_of(history, series.name, study);
    if (error.limit_m.empty()) continue;
    monitor["limit_m"] = error.limit_m;
    monitor["uncertainty_m"] = error.uncertainty_m;
  }
  std::cout << json.dump() << '\n';
}

void print_table(const CurlHistory& history) {
  std::vector<std::string> headings{">time s", ">cast mm"};
  for (const auto& series : history.monitors) headings.push_back(">" + series.name + " mm");
  render::Table table(headings);
  for (std::size_t i = 0; i < history.time_s.size(); ++i) {
    std::vector<std::string> row{render::fixed(history.time_s[i], 2),
                                 render::fixed(1e3 * history.cast_length_m[i], 2)};
    for (const auto& series : history.monitors)
      row.push_back(render::fixed(1e3 * series.curl_m[i], 3));
    table.add(std::move(row));
  }
  std::cout << table.text();
}

Study study_of_job(const Options& options, Connection& connection,
                   const v1::QueryResultResponse& result) {
  v1::GetJobRequest request;
  request.set_id(options.id);
  return study_around(connection, connection.call(&Stub::GetJob, request), result.case_());
}

ExitCode run(const Options& options, Program& program) {
  Connection connection = program.connect();
  v1::QueryResultRequest request;
  request.set_id(options.id);
  const auto result = connection.call(&Stub::QueryResult, request);
  CurlHistory history;
  for (const v1::StepReport& step : result.steps()) history.add(step);
  if (options.csv)
    print_csv(history, study_of_job(options, connection, result));
  else if (options.json)
    print_json(options.id, history, study_of_job(options, connection, result));
  else
    print_table(history);
  return ExitCode::done;
}

}  // namespace

void add_curl(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command = subcommand(
      app, "curl",
      "Butt curl (upward displacement) of every monitor, step by step. Of a job that belongs to "
      "a study, CSV and JSON also have the limit of every monitor and its uncertainty",
      "dccast curl JOB\n  dccast curl --csv JOB > curl.csv");
  command->add_option("JOB", options->id, "Job id, in any state")->required();
  CLI::Option* const csv =
      command->add_flag("--csv", options->csv, "Comma-separated, in metres and seconds");
  command->add_flag("--json", options->json, "As JSON, in metres and seconds")->excludes(csv);
  command->callback([options, &program] {
    program.action = [options, &program] { return run(*options, program); };
  });
}

}  // namespace dccast::client::commands
