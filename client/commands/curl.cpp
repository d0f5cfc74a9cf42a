#include <cmath>
#include <iostream>

#include "client/cli/common_options.hpp"
#include "client/commands/commands.hpp"
#include "client/model/answer.hpp"
#include "client/session/jobs.hpp"
#include "client/session/queries.hpp"
#include "client/session/studies.hpp"
#include "client/text/findings.hpp"
#include "client/text/job_csv.hpp"
#include "client/text/table.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/frames/contraction.hpp"
#include "proto/values/interpolation.hpp"

namespace dccast::client {
namespace {

struct CurlOptions {
  std::string id;
  bool csv = false;
  bool json = false;
};

Json monitor_json(const JobCurl& curl, const figures::MonitorSeries& series) {
  // One number for each time in a section, [x, y] in a quarter slab.
  const auto horizontal = [](const auto& u) { return u.size() == 1 ? Json(u[0]) : Json(u); };
  Json json{{"name", series.name},
            {"curl_m", series.curl_m},
            {"horizontal_m", json_list(series.horizontal_m, horizontal)},
            {"temperature_c", series.temperature_c}};
  const CurlError error = error_of(curl, series);
  if (!error.limit_m.empty()) json["limit_m"] = error.limit_m;
  if (!error.upper_m.empty()) {
    json["lower_error_m"] = error.lower_m;
    json["upper_error_m"] = error.upper_m;
  }
  return json;
}

void print_json(const JobCurl& curl) {
  const auto& [job, history, study] = curl;
  Json json{{"job", job.id()},
            {"time_s", history.time_s()},
            {"cast_length_m", history.cast_length_m()},
            {"beyond_validity", history.beyond()},
            {"validity_loss", job.has_validity_loss() ? to_json(job.validity_loss()) : Json()},
            {"findings", json_list(job.findings(), to_json)}};
  if (study.has_valid_until_s()) json["limit_valid_until_s"] = study.valid_until_s();
  json["monitors"] = json_list(history.monitors(), [&](const std::string& monitor) {
    return monitor_json(curl, curl.history.series(monitor));
  });
  print_line(json);
}

void print_table(const figures::RunHistory& history) {
  // A column that is empty in nearly every run would only widen the table.
  const bool lost = history.beyond_from_s().has_value();
  const std::vector<std::string> monitors = history.monitors();
  std::vector<std::string> headings{">time s", ">cast mm"};
  for (const std::string& monitor : monitors) headings.push_back(">" + monitor + " mm");
  if (lost) headings.push_back("validity");

  Table table(headings);
  for (const v1::StepReport& step : history.steps) {
    std::vector<std::string> row{fixed(step.time_s(), 2), mm(step.cast_length_m(), 2)};
    for (const std::string& monitor : monitors)
      row.push_back(mm(figures::curl_of(figures::monitor_of(step, monitor)), 3));
    if (lost) row.push_back(step.beyond_validity() ? beyond_validity : "");
    table.add(std::move(row));
  }
  std::cout << table.text() << std::flush;
}

/// The findings of a job, on standard error beside the table.
void print_findings(const v1::Job& job) {
  for (const v1::Finding& finding : job.findings()) std::cerr << finding_line(finding) << '\n';
  if (job.has_validity_loss()) std::cerr << validity_text(job.validity_loss()) << '\n';
}

ExitCode run(const CurlOptions& options, Program& program) {
  Connection connection = program.connect();
  const std::string id = resolve_job(connection, options.id);
  JobCurl curl = curl_of_job(connection, id);

  if (options.csv || options.json) {
    curl.study = refinement_of(connection, curl.job);
    if (options.csv)
      std::cout << curl_csv(curl);
    else
      print_json(curl);
    return ExitCode::done;
  }

  print_table(curl.history);
  if (curl.history.steps.empty()) return ExitCode::done;
  // Sentences go to standard error: scripts read the table.
  print_judgement(connection, run_of_job(id), std::cerr);
  print_findings(curl.job);
  return ExitCode::done;
}

using frames::Contraction, frames::FacePoint, frames::FaceRow;

struct ContractionOptions {
  std::string id;
  std::vector<std::string> heights;
  std::string wanted;
  bool json = false;
};

/// A row of the table, with its name.
using NamedRow = std::pair<std::string, const FaceRow*>;

/// Butt, middle and head, each row once, or the rows that were requested.
std::vector<NamedRow> chosen_rows(const Contraction& contraction,
                                  const ContractionOptions& options) {
  std::vector<NamedRow> rows;
  const auto add = [&](const char* name, const FaceRow& row) {
    if (rows.empty() || rows.back().second != &row) rows.push_back({name, &row});
  };
  if (!options.heights.empty()) {
    for (const std::string& text : options.heights)
      add("", contraction.at(metres_of(text, "--height")));
    return rows;
  }
  const FaceRow &butt = contraction.at(frames::butt_height_m), &head = contraction.head();
  add("butt", butt);
  // A short casting has not frozen through above its butt.
  if (head.height_m <= butt.height_m) return rows;
  add("middle", contraction.at(0.5 * (butt.height_m + head.height_m)));
  add("head", head);
  return rows;
}

std::string percent(double part, double whole) {
  return fixed(100.0 * part / whole, 2);
}

void print_table(const Contraction& contraction, const ContractionOptions& options) {
  std::vector<std::string> headings{"place",        ">height mm", ">x mm",           ">mould mm",
                                    ">now mm",      ">20 °C mm",  ">pull-in now mm", ">%",
                                    ">at 20 °C mm", ">%"};

  const bool compared = !options.wanted.empty();
  const double wanted_m = compared ? metres_of(options.wanted, "--wanted") : 0.0;
  if (compared) headings.push_back(">over wanted mm");
  Table table(headings);

  // "now" is hot; "20 °C" leaves out residual stresses (docs/contraction.md).
  for (const auto& [name, row] : chosen_rows(contraction, options))
    for (const FacePoint& p : row->points) {
      std::vector<std::string> cells{name,
                                     fixed(1e3 * row->height_m, 1),
                                     fixed(1e3 * p.x_m, 1),
                                     fixed(1e3 * p.mould_m, 2),
                                     fixed(1e3 * p.now_m, 2),
                                     fixed(1e3 * p.cold_m, 2),
                                     fixed(1e3 * p.pull_in_m(), 2),
                                     percent(p.pull_in_m(), p.mould_m),
                                     fixed(1e3 * p.cold_pull_in_m(), 2),
                                     percent(p.cold_pull_in_m(), p.mould_m)};
      if (compared) cells.push_back(fixed(1e3 * (p.cold_m - wanted_m), 2));
      table.add(std::move(cells));
    }

  std::cout << table.text() << std::flush;
}

/// NaN is written as null.
Json json_of(const FaceRow& row) {
  Json json{{"height_m", row.height_m}, {"solid", row.solid}};
  for (const FacePoint& p : row.points) {
    json["x_m"].push_back(p.x_m);
    json["mould_half_opening_m"].push_back(p.mould_m);
    json["half_thickness_m"].push_back(p.now_m);
    json["half_thickness_at_20_c_m"].push_back(p.cold_m);
    json["pull_in_m"].push_back(p.pull_in_m());
    json["pull_in_at_20_c_m"].push_back(p.cold_pull_in_m());
  }
  return json;
}

/// All rows, independently of those shown in the table.
void print_json(const std::string& id, const Contraction& contraction) {
  print_line({{"job", id},
              {"time_s", contraction.time_s},
              {"cast_length_m", contraction.cast_length_m},
              {"rows", json_list(contraction.rows, json_of)}});
}

ExitCode run(const ContractionOptions& options, Program& program) {
  Connection connection = program.connect();
  const std::string id = resolve_job(connection, options.id);
  v1::QueryResultResponse result;
  check(try_query_result(connection, id, LastFrame::computed, result), connection.server());
  try {
    const Contraction contraction = frames::contraction_of(result.case_(), result.frame());
    if (options.json)
      print_json(id, contraction);
    else
      print_table(contraction, options);
  } catch (const frames::NoContraction& error) {
    throw invalid(error.what());
  }
  return ExitCode::done;
}

}  // namespace

void add_curl(CommandLine& line, Program& program) {
  const auto [command, options] = declare<CurlOptions>(
      line, program, run, "curl",
      "Butt curl (upward displacement) of every monitor, step by step. Of a job that belongs to a "
      "study, CSV and JSON also have the limit of every monitor and its uncertainty. Steps after "
      "the model had stopped being valid are marked",
      "dccast curl JOB\n  dccast curl --csv JOB > curl.csv");
  command.option("JOB", options.id, job_help, required);
  command.flag("--csv", options.csv, "Comma-separated, in metres and seconds");
  command.json(options.json, "As JSON, in metres and seconds", {.excludes = {"--csv"}});
}

void add_contraction(CommandLine& line, Program& program) {
  const auto [command, options] = declare<ContractionOptions>(
      line, program, run, "contraction",
      "Half-thickness of a quarter slab along its wide face at butt, middle and head in the last "
      "frame, compared with the mould: hot and at 20 degC. The head is the highest row that is "
      "completely solid",
      "dccast contraction JOB\n  dccast contraction last --wanted \"285 mm\" --height \"0.3 m\"");
  command.option("JOB", options.id, job_help, required);
  command.option("--height", options.heights,
                 "Show the row nearest to this height above the block instead; repeatable");
  command.option("--wanted", options.wanted,
                 "Wanted half-thickness: adds the difference of the cold slab to it");
  command.json(options.json, "As JSON in metres, all rows", {.excludes = {"--height", "--wanted"}});
}

}  // namespace dccast::client
