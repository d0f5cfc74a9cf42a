#include <iostream>

#include "client/commands/commands.hpp"
#include "client/message_json.hpp"
#include "client/render/curl_history.hpp"
#include "client/render/table.hpp"
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

void print_csv(const CurlHistory& history) {
  std::cout << "time_s,cast_length_m";
  for (const auto& series : history.monitors) std::cout << ',' << csv_name(series.name + "_curl_m");
  std::cout << '\n';
  for (std::size_t i = 0; i < history.time_s.size(); ++i) {
    std::cout << case_file::number_text(history.time_s[i]) << ','
              << case_file::number_text(history.cast_length_m[i]);
    for (const auto& series : history.monitors)
      std::cout << ',' << case_file::number_text(series.curl_m[i]);
    std::cout << '\n';
  }
}

void print_json(const std::string& id, const CurlHistory& history) {
  Json json{{"job", id}, {"time_s", history.time_s}, {"cast_length_m", history.cast_length_m}};
  json["monitors"] = Json::array();
  for (const auto& series : history.monitors)
    json["monitors"].push_back(
        {{"name", series.name}, {"curl_m", series.curl_m}, {"horizontal_m", series.horizontal_m}});
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

ExitCode run(const Options& options, Program& program) {
  Connection connection = program.connect();
  v1::QueryResultRequest request;
  request.set_id(options.id);
  const auto result = connection.call(&Stub::QueryResult, request);
  CurlHistory history;
  for (const v1::StepReport& step : result.steps()) history.add(step);
  if (options.csv)
    print_csv(history);
  else if (options.json)
    print_json(options.id, history);
  else
    print_table(history);
  return ExitCode::done;
}

}  // namespace

void add_curl(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command =
      subcommand(app, "curl", "Butt curl (upward displacement) of every monitor, step by step",
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
