#include <fmt/core.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iostream>

#include "client/cli/common_options.hpp"
#include "client/commands/commands.hpp"
#include "client/html/pages.hpp"
#include "client/model/answer.hpp"
#include "client/model/judgement_json.hpp"
#include "client/session/jobs.hpp"
#include "client/session/queries.hpp"
#include "client/text/answer_text.hpp"
#include "client/text/findings.hpp"
#include "client/text/judgement_text.hpp"
#include "client/text/progress.hpp"

namespace dccast::client {
namespace {

struct QueryOptions {
  std::string file;
  std::vector<std::string> set;
  std::string line{};
  bool keep = false;
  bool json = false;
};

ExitCode refuse(const CaseUnderCheck& checked, bool json) {
  if (json) print_line(faults_json(checked));
  print_faults(checked, std::cerr);
  return ExitCode::invalid;
}

/// Draws the curve on a terminal while it is computed; the complete answer is printed at the end.
std::optional<Answer> ask(Connection& connection, CaseUnderCheck& checked,
                          const QueryOptions& options) {
  const Terminal terminal = terminal_of(STDOUT_FILENO);
  const bool draws = !options.json && terminal.interactive;
  Progress progress(std::cout, terminal);
  auto answer = ask_query(connection, checked, {.keep = options.keep}, [&](const auto& response) {
    // The progress display takes the events of a job; a query has only these two of them.
    v1::JobEvent event;
    if (response.has_waiting())
      event.mutable_message()->set_text(waiting_text(response.waiting()));
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

void print(Connection& connection, const Answer& answer, const std::string& line) {
  std::cout << answer_text(answer);
  if (!answer.history.steps.empty())
    print_judgement(connection, compared_run(answer), std::cout, line);
  std::cout << std::flush;
}

ExitCode run(const QueryOptions& options, Program& program) {
  CaseUnderCheck checked = read_case(options.file, changes_of(options.set));
  if (!checked.faults.empty()) return refuse(checked, options.json);
  Connection connection = program.connect();
  auto answer = ask(connection, checked, options);
  if (!answer) return refuse(checked, options.json);
  answer->name = checked.read.source.file();
  if (options.json) {
    Json json = answer_json(*answer);
    if (!options.line.empty())
      json["judgement"] = judgement_json(
          judge_run(connection, compared_run(*answer), JudgedParts::of_steps, options.line));
    print_line(json);
  } else {
    print(connection, *answer, options.line);
  }
  std::cerr << origin_text(*answer) << '\n';
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

/// Other runs are jobs whose results are already stored.
bool has_to_be_computed(const NamedRun& run) {
  return is_case_file(run.text) || !run.changes.empty();
}

/// A name that is not a file is a job.
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
    std::cerr << files[index].text << ": " << waiting_text(waiting) << std::endl;
  };
  // Answers come in the order of the cases, whichever ended first.
  for (auto& answer : ask_queries(connection, cases, on_wait)) {
    const NamedRun& file = files[answers.size()];
    if (!answer) refuse(cases[answers.size()], file.text);
    answer->name = file.text + (file.changes.empty() ? "" : ", changed");
    answers.push_back(std::move(*answer));
  }
  return answers;
}

v1::ComparedRun compared_job(Connection& connection, const std::string& text) {
  v1::ComparedRun run;
  run.set_job(resolve_job(connection, text));
  if (text != "last") run.set_name(text);
  return run;
}

std::vector<NamedRun> runs_of(const CompareOptions& options) {
  std::vector<NamedRun> runs;
  for (const std::string& text : options.runs) runs.push_back({text, {}});
  if (!options.set.empty()) runs.push_back({options.runs.front(), changes_of(options.set)});
  return runs;
}

/// The same case files at another quality: draft, or engineering for drafts.
std::vector<NamedRun> companions_of(const std::vector<NamedRun>& files,
                                    const std::vector<Answer>& answers) {
  std::vector<NamedRun> companions;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (!is_case_file(files[i].text) || files[i].text == "-") continue;
    companions.push_back(files[i]);
    v1::CaseChange& quality = companions.back().changes.emplace_back();
    quality.set_key("quality");
    quality.set_value(answers[i].description.quality() == v1::DRAFT ? "engineering" : "draft");
  }
  return companions;
}

/// Computes the missing runs, then has the server compare all.
v1::Comparison compare(Connection& connection, const std::vector<NamedRun>& runs, bool paired) {
  std::vector<NamedRun> files;
  std::ranges::copy_if(runs, std::back_inserter(files), has_to_be_computed);
  const std::vector<Answer> answers = answers_of_files(connection, files);

  v1::CompareRunsRequest request;
  auto next = answers.begin();
  for (const NamedRun& run : runs)
    *request.add_runs() =
        has_to_be_computed(run) ? compared_run(*next++) : compared_job(connection, run.text);
  if (paired)
    for (const Answer& answer : answers_of_files(connection, companions_of(files, answers)))
      *request.add_companions() = compared_run(answer);
  v1::Comparison comparison = connection.call(&Stub::CompareRuns, request);

  // The server identifies answers by a key. Titles and texts of changes are known to the client
  // only.
  next = answers.begin();
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (!has_to_be_computed(runs[i])) continue;
    auto& summary = *comparison.mutable_runs(static_cast<int>(i));
    summary.set_title(next->description.title());
    *summary.mutable_changes() = {next->changes.begin(), next->changes.end()};
    ++next;
  }
  return comparison;
}

void require_runs(const CompareOptions& options) {
  if (options.set.empty() && options.runs.size() < 2)
    throw invalid("give two runs, or one and what to change in its case with --set");
  if (!options.set.empty() && options.runs.front() == "-")
    throw invalid("--set changes the first RUN, a case file or a job; standard input is read once");
}

std::string names_text(const v1::Comparison& comparison) {
  std::string text;
  for (int i = 0; i < comparison.runs_size(); ++i) {
    const auto& run = comparison.runs(i);
    text += fmt::format("{}  {}{}{}\n", i + 1, run.name(), run.title().empty() ? "" : "  ",
                        run.title());
    if (!run.changes().empty()) text += fmt::format("   {}\n", changes_text(run.changes()));
  }
  return text;
}

std::string findings_text(const v1::Comparison& comparison) {
  std::string text;
  for (int i = 0; i < comparison.runs_size(); ++i)
    for (const v1::Finding& finding : comparison.runs(i).findings())
      text += fmt::format("run {}: {}\n", i + 1, finding_line(finding));
  return text;
}

std::string comparison_text(const v1::Comparison& comparison) {
  constexpr int columns = 120;
  return fmt::format("{}\n{}{}\n{}", names_text(comparison),
                     parts_text(comparison.judgement(), terminal_of(STDOUT_FILENO),
                                {.capitals = true, .headings = false}),
                     findings_text(comparison), sentences_text(comparison.judgement(), columns, 2));
}

Json comparison_json(const v1::Comparison& comparison) {
  Json json = judgement_json(comparison.judgement());
  json["runs"] = json_list(comparison.runs(), to_json);
  return json;
}

ExitCode run(const CompareOptions& options, Program& program) {
  require_runs(options);
  require_free(options.output, options.force);
  Connection connection = program.connect();
  const v1::Comparison comparison = compare(connection, runs_of(options), options.paired);

  if (!options.output.empty()) write_output(options.output, comparison_page(comparison));
  if (options.json)
    print_line(comparison_json(comparison));
  else
    std::cout << comparison_text(comparison);
  return ExitCode::done;
}

}  // namespace

void print_judgement(Connection& connection, const v1::ComparedRun& run, std::ostream& stream,
                     const std::string& line) try {
  constexpr int columns = 100;  // of text that is read, tables may be wider
  const int descriptor = &stream == &std::cout ? STDOUT_FILENO : STDERR_FILENO;
  const v1::Judgement judgement = judge_run(connection, run, JudgedParts::of_steps, line);
  stream << parts_text(judgement, terminal_of(descriptor)) << '\n'
         << sentences_text(judgement, columns, 2);
} catch (const Interrupted&) {
  throw;
} catch (const CommandFailed& failure) {
  std::cerr << "dccast: " << failure.what() << '\n';
}

ExitCode check_by_draft(const std::string& file, Program& program) {
  return run(QueryOptions{.file = file, .set = {"quality=draft"}}, program);
}

void add_query(CommandLine& line, Program& program) {
  const auto [command, options] =
      declare<QueryOptions>(line, program, run, "query",
                            "Compute the curl of a case at once, without a job", query_examples);
  command.option("FILE", options.file, "Case file; - for standard input", required);
  add_set_option(command, options.set);
  command.option("--line", options.line,
                 "Also what the castings of this line say of its recipe (dccast line add)");
  command.flag("--keep", options.keep, "Keep the run as a job, with its results");
  command.json(options.json, "As JSON, in metres and seconds, with the history");
}

void add_compare(CommandLine& line, Program& program) {
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
  command.option("-o,--output", options.output, "Also write this HTML page");
  add_force_flag(command, options.force);
  command.json(options.json, "As JSON, in metres and seconds");
}

}  // namespace dccast::client
