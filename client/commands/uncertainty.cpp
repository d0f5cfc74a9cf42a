#include <algorithm>
#include <iostream>

#include "client/cli/common_options.hpp"
#include "client/commands/commands.hpp"
#include "client/session/data_study.hpp"
#include "client/session/studies.hpp"
#include "proto/case_file/uncertainty.hpp"

namespace dccast::client {
namespace {

/// Options of `uncertainty` and `sensitivity`.
struct DataOptions : StudyOptions {
  DataPlan plan;
  std::string point, band;
  std::string line;
  bool assume_sound = false;
};

/// Converts "35..45 mm" to the curl limits of the case.
void take_band(const std::string& band, std::vector<std::string>& changes) {
  if (band.empty()) return;
  const auto range = case_file::parse_range(band);
  if (!range || !range->suffix.empty()) throw invalid("--band " + band + ": write it as 35..45 mm");
  changes.push_back("plausibility.least_curl=" + range->low);
  changes.push_back("plausibility.greatest_curl=" + range->high);
}

/// Differences between the two commands.
struct Kind {
  std::string name;
  void (*lay_out)(const DataPlan&, v1::CreateStudyRequest&);
  bool (*has_answer)(const v1::StudyJudgement&);
};

bool has_spread(const v1::StudyJudgement& answer) {
  return answer.result().has_spread();
}

/// Effects need a valid run of the case itself, with which those of its data are compared.
bool has_effects(const v1::StudyJudgement& answer) {
  return std::ranges::any_of(answer.judgement().parts(), [](const v1::JudgementPart& part) {
    return part.table().key() == "effects" && !part.table().rows().empty();
  });
}

ExitCode run(DataOptions options, const Kind& kind, Program& program) {
  if (options.base.file.empty() == options.study.empty())
    throw invalid("give a case FILE to begin, or --study ID to take one up again");
  require_free(options.plot, options.force);
  take_band(options.band, options.base.set);

  Connection connection = program.connect();
  std::string id = options.study.empty() ? "" : resolve_study(connection, options.study);
  const std::string come_back = "dccast " + kind.name + " --study ";
  if (id.empty()) {
    const auto study = create_study(connection, options.base, [&](v1::CreateStudyRequest& request) {
      kind.lay_out(options.plan, request);
    });
    if (!study) return ExitCode::invalid;
    id = study->id();
    std::cerr << "study " << id << ", " << study->runs() << " runs over "
              << study->sweep().axes_size() << " keys; taken up again by " << come_back << id
              << '\n';
    if (options.no_wait) {
      std::cout << id << std::endl;
      return ExitCode::done;
    }
  }

  if (!options.no_wait) follow_with_progress(connection, id, come_back + id);
  const auto answer = judge_study(connection, {.id = id,
                                               .monitor = options.point,
                                               .line = options.line,
                                               .assume_sound = options.assume_sound});
  print_answer(options, answer);
  return exit_code_of(answer, kind.has_answer(answer));
}

ExitCode run_uncertainty(const DataOptions& options, Program& program) {
  return run(options, {"uncertainty", lay_out_uncertainty, has_spread}, program);
}

ExitCode run_sensitivity(const DataOptions& options, Program& program) {
  return run(options, {"sensitivity", lay_out_sensitivity, has_effects}, program);
}

void add_common(const Command& command, DataOptions& options, const char* plot) {
  command.option("FILE", options.base.file, "Case file");
  command.option("--only", options.plan.only, "Only this datum; repeatable");
  command.option("--point", options.point, "Monitor; absent: output.curl, or the largest curl");
  add_study_options(
      command, options,
      {.study = "Take this study up again", .plot = plot, .json = "As JSON, in metres"});
}

}  // namespace

void add_uncertainty(CommandLine& line, Program& program) {
  const auto [command, options] = declare<DataOptions>(
      line, program, run_uncertainty, "uncertainty",
      "How sure a curl is: what the ranges of its data leave open, and which datum to measure "
      "first",
      "dccast uncertainty start-3d.toml --band '35..45 mm'\n"
      "  dccast uncertainty my.toml --runs 100 --only alloy.coherency_solid_fraction\n"
      "  dccast uncertainty --study ID --line pit-3   given what was cast there\n"
      "  dccast uncertainty --study ID --no-wait      what there is so far\n"
      "\n"
      "Ranges are given in [uncertainty] of case and alloy card (docs/uncertainty.md). Runs are\n"
      "drafts unless --set quality=... chooses another, and wait behind all other jobs.");
  command.number("--runs", options.plan.runs, 8, 10000, "Runs of the Latin hypercube");
  command.option("--seed", options.plan.seed, "Its seed", shown);
  command.option("--band", options.band, "Curls that the plant accepts, as 35..45 mm");
  command.option("--line", options.line,
                 "Condition the answer on the castings of this line (dccast line add)");
  command.flag("--assume-sound", options.assume_sound,
               "Condition it on 200 sound castings that nobody has recorded");
  add_common(command, options,
             "Write an HTML page with the bands of data and of mesh; - for standard output");
}

void add_sensitivity(CommandLine& line, Program& program) {
  const auto [command, options] = declare<DataOptions>(
      line, program, run_sensitivity, "sensitivity",
      "What matters: the change of a curl at the two ends of the range of every lever and datum",
      "dccast sensitivity start-3d.toml --plot sensitivity.html\n"
      "\n"
      "Levers move by a tenth, or by what a plant changes between two castings; data over their\n"
      "[uncertainty] (docs/uncertainty.md). Two drafts for each.");
  add_common(command, options, "Write an HTML page with a bar for each; - for standard output");
}

}  // namespace dccast::client
