// dccast-verify: compares the core with the paper's tests and tables and with exact solutions.
//   exit code 0 all passed   2 wrong usage   3 a run failed or missed its bound

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "tests/verification/program/casting_history.hpp"
#include "tests/verification/program/claims.hpp"
#include "tests/verification/program/named_tests.hpp"
#include "tests/verification/program/paper_tables.hpp"
#include "tests/verification/program/report.hpp"

namespace dccast::verification {
namespace {

constexpr int success = 0, usage = 2, missed = 3;

int list(bool as_json) {
  if (as_json) {
    auto tests = nlohmann::json::array();
    for (const NamedTest& t : named_tests()) {
      tests.push_back({{"name", t.name}, {"shows", t.shows}, {"lasts", t.lasts}});
    }
    std::cout << tests.dump(2) << "\n";
    return success;
  }

  for (const NamedTest& t : named_tests()) {
    std::printf("%-14s %-72s %s\n", t.name.c_str(), t.shows.c_str(), t.lasts.c_str());
  }
  return success;
}

nlohmann::json to_json(const RunRequest& request, const Figures& figures) {
  nlohmann::json out = figures.more;
  out["name"] = request.name;
  out["algorithm"] = name_of(request.algorithm);
  out["command"] = command_of(request);

  // JSON has no "not a number": these are null for heat runs.
  out["displacement_error"] = figures.displacement_error;
  out["stress_error"] = figures.stress_error;

  out["iterations_per_step"] = figures.iterations_per_step;
  out["cpu_s"] = figures.cpu_s;
  out["elements"] = nullptr;  // heat strips know their nodes only
  if (figures.elements > 0) out["elements"] = figures.elements;
  out["nodes"] = figures.nodes;
  out["steps"] = figures.steps;
  return out;
}

/// Prints one figure per line, without those that are not a number.
void print(const Figures& figures) {
  const auto line = [](const std::string& key, double value) {
    if (value == value) std::printf("%-36s %.6g\n", key.c_str(), value);
  };

  line("displacement_error", figures.displacement_error);
  line("stress_error", figures.stress_error);
  line("iterations_per_step", figures.iterations_per_step);
  line("cpu_s", figures.cpu_s);
  if (figures.elements > 0) line("elements", double(figures.elements));
  line("nodes", double(figures.nodes));
  line("steps", double(figures.steps));
  for (const auto& [key, value] : figures.more) line(key, value);
}

int run(const RunRequest& request, bool as_json) {
  Runs runs;
  const Result& result = runs.of(request);
  if (const auto* failed = std::get_if<Failed>(&result)) {
    if (as_json) {
      std::cout << nlohmann::json{{"name", request.name},
                                  {"command", command_of(request)},
                                  {"failed_at_s", failed->time},
                                  {"why", failed->why}}
                       .dump(2)
                << "\n";
    }
    std::fprintf(stderr, "%s failed at t = %g s: %s\n", request.name.c_str(), failed->time,
                 failed->why.c_str());
    return missed;
  }

  const Figures& figures = std::get<Figures>(result);
  auto out = to_json(request, figures);
  if (!as_json) print(figures);

  // Bounds that are claimed for exactly this request.
  int code = success;
  out["misses"] = nlohmann::json::array();
  for (const Claim* claim : claims_about(request)) {
    const double measured = figure(figures, claim->key);
    const Verdict verdict = judge_figure(*claim, measured);
    if (verdict.passed) continue;

    code = missed;
    const std::string text = miss_of(verdict);
    out["misses"].push_back(text);
    std::fprintf(stderr, "%s\n", text.c_str());
  }

  if (as_json) std::cout << out.dump(2) << "\n";
  return code;
}

int judge_claims(bool nightly, bool as_json) {
  Runs runs;
  std::vector<Verdict> verdicts;
  for (const Claim& claim : claims()) {
    if (claim.nightly && !nightly) continue;
    verdicts.push_back(judge(claim, runs));
    if (!as_json) {
      std::fprintf(stderr, "%s %s\n", verdicts.back().passed ? "pass" : "MISS", claim.what.c_str());
    }
  }

  const Table table = table_of(verdicts);
  std::cout << (as_json ? to_json(table).dump(2) + "\n" : to_markdown(table));

  const auto misses =
      std::count_if(verdicts.begin(), verdicts.end(), [](const Verdict& v) { return !v.passed; });
  std::fprintf(stderr, "%zu figures, %ld missed\n", verdicts.size(), long(misses));
  return misses == 0 ? success : missed;
}

int table(int number, const TableOptions& options, bool as_json) {
  const auto made = paper_table(number, options);
  if (!made) {
    std::fprintf(stderr, "there is no table %d here; there are 1 to 8%s\n", number,
                 has_casting_table() ? " and 11" : " (11 needs the whole project built)");
    return usage;
  }
  std::cout << (as_json ? to_json(*made).dump(2) + "\n" : to_markdown(*made));
  for (const std::string& failure : made->missed) std::fprintf(stderr, "%s\n", failure.c_str());
  return made->missed.empty() ? success : missed;
}

int elements_under_refinement(const TableOptions& options, bool as_json) {
  const ElementComparison made = compare_elements(options);
  std::cout << (as_json ? to_json(made.table).dump(2) + "\n" : to_markdown(made.table));
  return made.same_limit ? success : missed;
}

int report(const std::string& file, const ReportOptions& options) {
  std::ofstream out(file);
  out << html_report(options);
  out.close();
  if (!out) {
    std::fprintf(stderr, "%s cannot be written\n", file.c_str());
    return usage;
  }
  std::printf("%s\n", file.c_str());
  return success;
}

/// Runs a program of Python in this one's place. @return only when it cannot be run
int become(std::vector<std::string> words) {
  words.insert(words.begin(), "/usr/bin/python3");
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  execv(arguments.front(), arguments.data());
  std::fprintf(stderr, "/usr/bin/python3 cannot be run: install python3\n");
  return usage;
}

/// Scores the predictions, or predicts what dccast can.
int use_record(const std::vector<std::string>& predictions, const std::string& file) {
  if (predictions.empty()) {
    return become({DCCAST_SOURCES "/tests/verification/record/ours.py",
                   std::filesystem::read_symlink("/proc/self/exe").parent_path(), file});
  }
  std::vector<std::string> words{DCCAST_SOURCES "/tests/record/record.py", "score"};
  words.insert(words.end(), predictions.begin(), predictions.end());
  return become(words);
}

int shear(const FictitiousLiquid& liquid, const std::string& file) {
  std::ofstream out(file);
  out << shear_picture(liquid);
  out.close();
  return out ? success : usage;
}

const std::map<std::string, mechanics::Algorithm> algorithms{
    {"newton", mechanics::Algorithm::newton},
    {"vnbm", mechanics::Algorithm::vnbm},
    {"sbm", mechanics::Algorithm::sbm},
    {"nbm", mechanics::Algorithm::nbm}};
const std::map<std::string, mesh::ElementKind> elements{
    {"p1", mesh::ElementKind::p1},
    {"q1", mesh::ElementKind::q1},
    {"q1_bending", mesh::ElementKind::q1_bending}};
const std::map<std::string, Diagonals> diagonal_names{{"rising", Diagonals::rising},
                                                      {"falling", Diagonals::falling},
                                                      {"mirrored", Diagonals::mirrored},
                                                      {"mirrored-back", Diagonals::mirrored_back}};

/// The options of `run`; those of a fictitious liquid make T1 extended.
struct RunCommand {
  RunRequest request;
  FictitiousLiquid liquid;
  CLI::App* app = nullptr;

  void add_to(CLI::App& program) {
    app = program.add_subcommand("run", "run one test");
    app->add_option("name", request.name, "its name, as `list` prints it")->required();
    app->add_option("--algorithm", request.algorithm, "newton, vnbm, sbm or nbm")
        ->transform(CLI::CheckedTransformer(algorithms));
    app->add_option("--dt", request.dt, "time step [s]")->check(CLI::PositiveNumber);
    app->add_option("--end", request.end, "end of the run [s]")->check(CLI::PositiveNumber);
    app->add_option("--cells", request.cells, "cells per side")->check(CLI::PositiveNumber);
    app->add_option("--element", request.element, "p1, q1 or q1_bending")
        ->transform(CLI::CheckedTransformer(elements));
    app->add_option("--tolerance", request.tolerance, "relative residual")
        ->check(CLI::PositiveNumber);
    app->add_flag("--plain", request.plain, "nbm without its improvements");
    app->add_flag("--cut-steps", request.cut_steps, "with --plain: halve a step that fails");
    app->add_flag("--increment-test", request.increment_test, "stop as the paper does");
    app->add_option("--epsilon", liquid.epsilon, "T1: makes it extended")
        ->check(CLI::PositiveNumber);
    app->add_option("--delta", liquid.delta, "T1 extended");
    app->add_option("--beta", liquid.beta, "T1 extended");
    app->add_option("--diagonals", request.diagonals, "T1: cut of its cells")
        ->transform(CLI::CheckedTransformer(diagonal_names));
    app->add_option("--data", request.data, "strand: JSON file")->check(CLI::ExistingFile);
  }
  void finish() {
    if (app->count("--epsilon") + app->count("--delta") + app->count("--beta") > 0) {
      request.liquid = liquid;
    }
  }
};

/// The options of `history`.
struct HistoryCommand {
  HistoryRequest request;
  CLI::App* app = nullptr;

  void add_to(CLI::App& program) {
    app = program.add_subcommand("history",
                                 "the start of a casting on any mesh and steps: curl and seconds");
    app->add_option("--element", request.element, "p1, q1 or q1_bending")
        ->transform(CLI::CheckedTransformer(elements));
    request.add_to(*app);
  }
};

/// The options of `shear`.
struct ShearCommand {
  FictitiousLiquid liquid;
  std::string picture = "shear.svg";
  CLI::App* app = nullptr;

  void add_to(CLI::App& program) {
    app = program.add_subcommand("shear", "shear stresses of T1 as SVG");
    app->add_option("--epsilon", liquid.epsilon)->check(CLI::PositiveNumber);
    app->add_option("--delta", liquid.delta);
    app->add_option("--beta", liquid.beta);
    app->add_option("-o,--output", picture, "file to write");
  }
};

int run_program(int argc, char** argv) {
  CLI::App program{"dccast-verify: the paper's tests and tables, and exact checks"};
  program.require_subcommand(1);
  bool as_json = false, nightly = false;

  auto* list_command = program.add_subcommand("list", "name every test");
  RunCommand run_command;
  run_command.add_to(program);

  auto* all_command = program.add_subcommand("all", "every figure with its bound");
  all_command->add_flag("--nightly", nightly, "also those that take minutes");

  auto* table_command = program.add_subcommand("table", "a table of the paper next to ours");
  int number = 0;
  TableOptions table_options;
  table_command->add_option("number", number, "1 to 8, or 11")->required();
  table_command->add_flag("--full", table_options.full,
                          "tables 4 to 6 at the paper's time step (many minutes)");
  table_command->add_option("--limit", table_options.limit,
                            "table 11: stop an algorithm after this number of seconds");
  table_command->add_flag("--slab", table_options.slab, "table 11: in three dimensions (nightly)");

  auto* elements_command =
      program.add_subcommand("elements", "error of the curl by element, and its cost (minutes)");
  elements_command->add_option("--limit", table_options.limit,
                               "stop a run after this number of seconds");

  HistoryCommand history_command;
  history_command.add_to(program);
  for (auto* command :
       {list_command, run_command.app, all_command, table_command, elements_command}) {
    command->add_flag("--json", as_json, "as JSON");
  }

  auto* report_command = program.add_subcommand("report", "an HTML file with all results");
  std::string file = "verification.html";
  ReportOptions report_options;
  report_command->add_option("-o,--output", file, "file to write");
  report_command->add_flag("--nightly", report_options.nightly, "also tests that take minutes");
  report_command->add_flag("--no-casting", report_options.no_casting, "leave table 11 out");
  report_command->add_option("--limit", report_options.limit, "as for table 11");

  ShearCommand shear_command;
  shear_command.add_to(program);

  auto* record_command = program.add_subcommand(
      "record", "predict the castings of tests/record and seal it (ten minutes), or score files");
  std::vector<std::string> predictions;
  std::string prediction = "dccast.json";
  record_command->add_option("file", predictions, "sealed predictions of any code, to be scored");
  record_command->add_option("-o,--output", prediction, "file for the prediction of dccast");

  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return program.exit(e) == 0 ? success : usage;
  }
  run_command.finish();

  if (*list_command) return list(as_json);
  if (*run_command.app) return run(completed(run_command.request), as_json);
  if (*all_command) return judge_claims(nightly, as_json);
  if (*table_command) return table(number, table_options, as_json);
  if (*elements_command) return elements_under_refinement(table_options, as_json);
  if (*history_command.app) return write_history(history_command.request) ? success : missed;
  if (*record_command) return use_record(predictions, prediction);
  if (*shear_command.app) return shear(shear_command.liquid, shear_command.picture);
  return report(file, report_options);
}

}  // namespace
}  // namespace dccast::verification

int main(int argc, char** argv) {
  try {
    return dccast::verification::run_program(argc, argv);
  } catch (const std::invalid_argument& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 2;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 3;
  }
}
