#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iostream>

#include "client/cli/common_options.hpp"
#include "client/commands/commands.hpp"
#include "client/html/pages.hpp"
#include "client/model/answer.hpp"
#include "client/model/comparison.hpp"
#include "client/session/jobs.hpp"
#include "client/session/queries.hpp"
#include "client/text/comparison_text.hpp"
#include "client/text/progress.hpp"

namespace dccast::client::commands {
namespace {

struct QueryOptions {
  std::string file;
  std::vector<std::string> set;
  bool keep = false;
  bool json = false;
};

ExitCode refuse(const CaseUnderCheck& checked, bool json) {
  if (json) print_line(faults_json(checked));
  print_faults(checked, std::cerr);
  return ExitCode::invalid;
}

/// The curve as it is computed, on a terminal; the answer as a whole is printed at its end.
std::optional<Answer> ask(Connection& connection, CaseUnderCheck& checked,
                          const QueryOptions& options) {
  const render::Terminal terminal = render::terminal_of(STDOUT_FILENO);
  const bool draws = !options.json && terminal.interactive;
  render::Progress progress(std::cout, terminal);
  auto answer = ask_query(connection, checked, {.keep = options.keep}, [&](const auto& response) {
    v1::JobEvent event;
    if (response.has_waiting())
      event.mutable_message()->set_text(render::waiting_text(response.waiting()));
    else if (response.has_step())
      *event.mutable_step() = response.step();
    else
      return;

    if (draws)
      progress.show(event);
    else if (event.has_message())
      std::cerr << event.message().text() << std::endl;
  });
  if (draws) progress.finish();
  return answer;
}

ExitCode run(const QueryOptions& options, Program& program) {
  CaseUnderCheck checked = read_case(options.file, changes_of(options.set));
  if (!checked.faults.empty()) return refuse(checked, options.json);
  Connection connection = program.connect();
  auto answer = ask(connection, checked, options);
  if (!answer) return refuse(checked, options.json);
  answer->name = checked.read.source.file();
  std::cout << (options.json ? render::answer_json(*answer).dump() + "\n"
                             : render::answer_text(*answer))
            << std::flush;
  std::cerr << render::origin_text(*answer) << '\n';
  return exit_code_of(answer->state);
}

constexpr const char* query_examples =
    "dccast query my.toml\n"
    "  dccast query my.toml --set schedule.hold=\"90 s\" --set "
    "schedule.water_flow.scale=\"0.8 until 100 mm\"\n"
    "  dccast query --json my.toml | jq '.monitors[] | {name, end_curl_m}'\n"
    "\n"
    "Runs at once, beside the queue. Ctrl-C ends the run. A case that was computed before, by a "
    "job\n"
    "or a query, is answered from the store.";

struct CompareOptions {
  std::vector<std::string> runs;
  std::vector<std::string> set;
  std::string output;
  bool paired = false;
  bool force = false;
  bool json = false;
};

bool is_case_file(const std::string& text) {
  std::error_code error;
  return text == "-" || std::filesystem::exists(text, error);
}

/// A run as given on the command line: a job, or a case file with changes.
struct NamedRun {
  std::string text;
  std::vector<v1::CaseChange> changes;
};

/// Of the others the answer is there, in the job.
bool has_to_be_computed(const NamedRun& run) {
  return is_case_file(run.text) || !run.changes.empty();
}

/// A name that is not a file is taken as a job.
CaseUnderCheck case_of(Connection& connection, const NamedRun& run) {
  if (is_case_file(run.text)) return read_case(run.text, run.changes);
  return read_case_of_job(connection, resolve_job(connection, run.text), run.changes);
}

[[noreturn]] void refuse(const CaseUnderCheck& checked, const std::string& file) {
  print_faults(checked, std::cerr);
  throw invalid(file + " has faults");
}

/// Computes the cases concurrently, except those that were computed before.
std::vector<Answer> answers_of_files(Connection& connection, const std::vector<NamedRun>& files) {
  std::vector<CaseUnderCheck> cases;
  for (const NamedRun& file : files) {
    cases.push_back(case_of(connection, file));
    if (!cases.back().faults.empty()) refuse(cases.back(), file.text);
  }
  std::vector<Answer> answers;
  const auto on_wait = [&](std::size_t index, const auto& waiting) {
    std::cerr << files[index].text << ": " << render::waiting_text(waiting) << std::endl;
  };
  for (auto& answer : ask_queries(connection, cases, on_wait)) {
    const NamedRun& file = files[answers.size()];
    if (!answer) refuse(cases[answers.size()], file.text);
    answer->name = file.text + (file.changes.empty() ? "" : ", changed");
    answers.push_back(std::move(*answer));
  }
  return answers;
}

Answer answer_of_named_job(Connection& connection, const std::string& text) {
  const std::string id = resolve_job(connection, text);
  Answer answer = answer_of_job(connection, id);
  answer.name = text == "last" ? id.substr(0, 8) : text;
  return answer;
}

std::vector<NamedRun> runs_of(const CompareOptions& options) {
  std::vector<NamedRun> runs;
  for (const std::string& text : options.runs) runs.push_back({text, {}});
  if (!options.set.empty()) runs.push_back({options.runs.front(), changes_of(options.set)});
  return runs;
}

std::vector<Answer> answers_to(Connection& connection, const std::vector<NamedRun>& runs) {
  std::vector<NamedRun> files;
  for (const NamedRun& run : runs)
    if (has_to_be_computed(run)) files.push_back(run);
  std::vector<Answer> computed = answers_of_files(connection, files);
  auto next = computed.begin();
  std::vector<Answer> answers;
  for (const NamedRun& run : runs)
    answers.push_back(has_to_be_computed(run) ? std::move(*next++)
                                              : answer_of_named_job(connection, run.text));
  return answers;
}

/// The case files at another quality: draft, or engineering where they are draft themselves.
std::vector<Answer> companions_of(Connection& connection, const std::vector<NamedRun>& runs,
                                  const std::vector<Answer>& answers) {
  std::vector<NamedRun> files;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (!is_case_file(runs[i].text) || runs[i].text == "-") continue;
    files.push_back(runs[i]);
    v1::CaseChange& quality = files.back().changes.emplace_back();
    quality.set_key("quality");
    quality.set_value(answers[i].description.quality() == v1::DRAFT ? "engineering" : "draft");
  }
  return answers_of_files(connection, files);
}

void require_runs(const CompareOptions& options) {
  if (options.set.empty() && options.runs.size() < 2)
    throw invalid("give two runs, or one and what to change in its case with --set");
  if (!options.set.empty() && options.runs.front() == "-")
    throw invalid("--set changes the first RUN, a case file or a job; standard input is read once");
}

void write_comparison(const std::vector<Answer>& answers,
                      const std::vector<CurlDifference>& differences, const std::string& file) {
  const auto monitors = render::monitors_of(answers);
  const bool svg = file.ends_with(".svg");
  if (svg && monitors.size() != 1)
    throw invalid("an SVG holds one monitor and these runs have " +
                  std::to_string(monitors.size()) + "; give an HTML file: -o comparison.html");
  write_output(file, svg ? render::svg_file(render::comparison_chart(answers, monitors[0]))
                         : render::comparison_page(answers, differences));
}

ExitCode run(const CompareOptions& options, Program& program) {
  require_runs(options);
  require_free(options.output, options.force);
  Connection connection = program.connect();
  const std::vector<NamedRun> runs = runs_of(options);
  const std::vector<Answer> answers = answers_to(connection, runs);
  const auto differences = curl_differences(
      answers, options.paired ? companions_of(connection, runs, answers) : std::vector<Answer>{});
  if (!options.output.empty()) write_comparison(answers, differences, options.output);
  if (options.json)
    print_line(render::comparison_json(answers, differences));
  else
    std::cout << render::comparison_text(answers, differences, render::terminal_of(1));
  return ExitCode::done;
}

}  // namespace

void add_query(cli::CommandLine& line, Program& program) {
  const auto [command, options] =
      declare<QueryOptions>(line, program, run, "query",
                            "Compute the curl of a case at once, without a job", query_examples);
  command.option("FILE", options.file, "Case file; - for standard input", cli::required);
  add_set_option(command, options.set);
  command.flag("--keep", options.keep, "Keep the run as a job, with its results");
  command.json(options.json, "As JSON, in metres and seconds, with the history");
}

void add_compare(cli::CommandLine& line, Program& program) {
  const auto [command, options] = declare<CompareOptions>(
      line, program, run, "compare",
      "Compare runs with the first one: what differs in their cases and their curls, whether the "
      "difference is real, and what differed before it. Case files are computed, as by query",
      "dccast compare JOB JOB\n  dccast compare -o trial.html last my.toml\n"
      "  dccast compare my.toml --set schedule.hold=\"90 s\"");
  command.option("RUN", options.runs, "Jobs or case files",
                 {.required = true, .count = {{1, 100}}});
  add_set_option(command, options.set,
                 "Also compare with the first RUN, a case file or a job, with this change");
  command.flag("--paired", options.paired,
               "Compute the case files at another quality too: the error of a difference then "
               "comes from the two pairs");
  command.option("-o,--output", options.output, "Also write this HTML or SVG file");
  add_force_flag(command, options.force);
  command.json(options.json, "As JSON, in metres and seconds");
}

}  // namespace dccast::client::commands
