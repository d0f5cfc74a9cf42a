#include <filesystem>
#include <fstream>
#include <iostream>

#include "client/case_options.hpp"
#include "client/commands/commands.hpp"
#include "client/commands/output_file.hpp"
#include "client/comparison.hpp"
#include "client/job_id.hpp"
#include "client/queries.hpp"
#include "client/render/comparison_text.hpp"

namespace dccast::client::commands {
namespace {

struct Options {
  std::vector<std::string> runs;
  std::vector<std::string> set;
  std::string output;
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

[[noreturn]] void refuse(const CaseUnderCheck& checked, const std::string& file) {
  print_faults(checked, std::cerr);
  throw CommandFailed(ExitCode::invalid, file + " has faults");
}

/// Computes the cases concurrently, except those that were computed before.
std::vector<Answer> answers_of_files(Connection& connection, const std::vector<NamedRun>& files) {
  std::vector<CaseUnderCheck> cases;
  for (const NamedRun& file : files) {
    cases.push_back(read_case(file.text, file.changes));
    if (!cases.back().faults.empty()) refuse(cases.back(), file.text);
  }
  std::vector<Answer> answers;
  for (auto& answer : ask_queries(connection, cases)) {
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

/// A name that is not a file is taken as a job.
std::vector<Answer> answers_to(Connection& connection, const Options& options) {
  std::vector<NamedRun> runs;
  for (const std::string& text : options.runs) runs.push_back({text, {}});
  if (!options.set.empty()) runs.push_back({options.runs.front(), changes_of(options.set)});
  std::vector<NamedRun> files;
  for (const NamedRun& run : runs)
    if (is_case_file(run.text)) files.push_back(run);
  std::vector<Answer> computed = answers_of_files(connection, files);
  auto next = computed.begin();
  std::vector<Answer> answers;
  for (const NamedRun& run : runs)
    answers.push_back(is_case_file(run.text) ? std::move(*next++)
                                             : answer_of_named_job(connection, run.text));
  return answers;
}

void require_runs(const Options& options) {
  if (options.set.empty() && options.runs.size() < 2)
    throw CommandFailed(ExitCode::invalid,
                        "give two runs, or a case file and what to change in it with --set");
  if (!options.set.empty() && (!is_case_file(options.runs.front()) || options.runs.front() == "-"))
    throw CommandFailed(ExitCode::invalid,
                        "--set changes the first RUN, which must be a case file; " +
                            options.runs.front() + " is none");
}

void write_file(const std::vector<Answer>& answers, const std::string& file) {
  const auto monitors = render::monitors_of(answers);
  const bool svg = file.ends_with(".svg");
  if (svg && monitors.size() != 1)
    throw CommandFailed(ExitCode::invalid, "an SVG holds one monitor and these runs have " +
                                               std::to_string(monitors.size()) +
                                               "; give an HTML file: -o comparison.html");
  std::ofstream stream(file, std::ios::binary);
  const std::string text = svg ? render::svg_file(render::comparison_chart(answers, monitors[0]))
                               : render::comparison_page(answers);
  if (!(stream << text << std::flush))
    throw CommandFailed(ExitCode::not_found, "cannot write " + file);
  std::cerr << "written: " << file << '\n';
}

ExitCode run(const Options& options, Program& program) {
  require_runs(options);
  if (!options.output.empty()) require_free(options.output, options.force);
  Connection connection = program.connect();
  const std::vector<Answer> answers = answers_to(connection, options);
  if (!options.output.empty()) write_file(answers, options.output);
  if (options.json)
    std::cout << render::comparison_json(answers).dump() << '\n';
  else
    std::cout << render::comparison_text(answers, render::terminal_of(1));
  std::cout << std::flush;
  return ExitCode::done;
}

}  // namespace

void add_compare(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command =
      subcommand(app, "compare",
                 "Compare runs with the first one: what differs in their cases, their curls, and "
                 "whether the difference is more than discretisation error. Case files are "
                 "computed, as by query",
                 "dccast compare JOB JOB\n  dccast compare -o trial.html last my.toml\n"
                 "  dccast compare my.toml --set schedule.casting_speed=\"70 mm/min\"");
  command->add_option("RUN", options->runs, "Jobs or case files")->required()->expected(1, 100);
  add_set_option(*command, options->set)
      ->description("Also compare with the first RUN, a case file, with this change");
  command->add_option("-o,--output", options->output, "Also write this HTML or SVG file");
  add_force_flag(*command, options->force);
  command->add_flag("--json", options->json, "As JSON, in metres and seconds");
  command->callback([options, &program] {
    program.action = [options, &program] { return run(*options, program); };
  });
}

}  // namespace dccast::client::commands
