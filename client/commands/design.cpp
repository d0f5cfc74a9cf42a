#include <iostream>

#include "client/cli/common_options.hpp"
#include "client/commands/commands.hpp"
#include "client/session/plan_requests.hpp"
#include "client/session/studies.hpp"

namespace dccast::client {
namespace {

struct MouldOptions : StudyOptions {
  std::string tolerance = "0.5 mm";
  std::string wanted;
  int most_runs = 0;
  bool flat = false;
};

v1::MouldPlan plan_of(const MouldOptions& options) {
  v1::MouldPlan plan;
  plan.set_tolerance_m(metres_of(options.tolerance, "--tolerance"));
  if (!options.wanted.empty())
    plan.set_wanted_half_thickness_m(metres_of(options.wanted, "--wanted"));
  plan.set_maximum_runs(options.most_runs);
  return plan;
}

/// A search that is still running has not failed. A face that is not steady is not a result yet.
ExitCode design_exit_code(const v1::StudyResult& result) {
  if (result.study().state() == v1::STUDY_RUNNING) return ExitCode::done;
  return result.mould().within_tolerance() && result.mould().is_steady() ? ExitCode::done
                                                                         : ExitCode::solve_failed;
}

ExitCode wait_and_print(Connection& connection, const MouldOptions& options,
                        const std::string& id) {
  if (!options.no_wait) follow_with_progress(connection, id, "dccast design-mould --study " + id);
  const v1::StudyJudgement answer = judge_study(connection, {.id = id});
  if (!answer.study().has_mould())
    throw invalid("study " + id + " designs no mould; dccast studies show " + id +
                  " shows what it is");
  print_answer(options, answer);
  return design_exit_code(answer.result());
}

ExitCode run(const MouldOptions& options, Program& program) {
  if (options.base.file.empty() == options.study.empty())
    throw invalid("give a CASE to begin, or --study ID to take a design up again");
  if (options.study.empty() && !options.flat)
    throw invalid("give the target for the cold slab: --flat");
  require_free(options.plot, options.force);

  Connection connection = program.connect();
  if (!options.study.empty())
    return wait_and_print(connection, options, resolve_study(connection, options.study));

  const v1::MouldPlan plan = plan_of(options);
  const auto study = create_study(connection, options.base, [&](v1::CreateStudyRequest& request) {
    *request.mutable_mould() = plan;
  });
  if (!study) return ExitCode::invalid;

  std::cerr << "study " << study->id() << "; taken up again by dccast design-mould --study "
            << study->id() << '\n';
  if (!options.no_wait) return wait_and_print(connection, options, study->id());
  std::cout << study->id() << std::endl;
  return ExitCode::done;
}

constexpr const char* mould_examples =
    R"(dccast design-mould stationary-3d.toml --flat --wanted "285 mm"
  dccast design-mould my.toml --flat --tolerance "1 mm" --set schedule.casting_speed="50 mm/min"
  dccast design-mould --study ID --plot mould.html   show an existing design, with a page of charts

The first run casts in the mould of the case; each further one in an opening corrected
by the deviation of the cold slab (docs/contraction.md). Exit code 3 when no opening within the
tolerance was found, or when the face that was found is not steady yet.)";

struct RecipeOptions : StudyOptions {
  RecipeChoice choice;
  std::string output;
};

/// Writes the case of the file with the changes of the chosen recipe, if there is one.
void write_chosen(Connection& connection, const RecipeOptions& options, const std::string& id) {
  v1::JudgeStudyRequest question;
  question.set_id(id);
  const std::string chosen = found_case(connection, question, options.base);
  if (chosen.empty())
    std::cerr << options.output << " is not written: no recipe is confirmed\n";
  else
    write_output(options.output, chosen);
}

ExitCode print(Connection& connection, const RecipeOptions& options, const std::string& id) {
  const v1::StudyJudgement answer = judge_study(connection, {.id = id});
  if (!answer.study().has_recipe())
    throw invalid("study " + id + " designs no recipe; dccast studies show " + id +
                  " shows what it is");
  if (!options.output.empty()) write_chosen(connection, options, id);
  print_answer(options, answer, options.output);
  const bool open = answer.study().state() == v1::STUDY_RUNNING;
  return open || answer.result().recipe().chosen() >= 0 ? ExitCode::done : ExitCode::solve_failed;
}

/// Follows a study that this command started and cancels at an interruption.
void follow_own(Connection& connection, const std::string& id) {
  try {
    follow_with_progress(connection, id, {});
  } catch (const Interrupted&) {
    cancel_after_interruption(connection, id);
    throw Interrupted("study " + id + " is cancelled; repeat the command to resume it");
  }
}

ExitCode begin(const RecipeOptions& options, Connection& connection) {
  const auto created = create_study(connection, options.base, [&](v1::CreateStudyRequest& request) {
    lay_out_recipe(connection, options.choice, request);
  });
  if (!created) return ExitCode::invalid;
  // The same plan finds its study, which may have been cancelled.
  const v1::Study study = taken_up(connection, *created);
  std::cerr << "study " << study.id() << ", " << study.recipe().numbers_size() << " numbers and "
            << study.recipe().data_size()
            << " data; Ctrl-C cancels it, the same command resumes it\n";
  if (options.no_wait) {
    std::cout << study.id() << std::endl;
    return ExitCode::done;
  }
  follow_own(connection, study.id());
  return print(connection, options, study.id());
}

ExitCode run(const RecipeOptions& options, Program& program) {
  if (options.base.file.empty() == options.study.empty())
    throw invalid("give a CASE to begin or to go on, or --study ID to show one");
  if (!options.output.empty() && options.base.file.empty())
    throw invalid("-o writes the CASE with the recipe: give CASE, too");
  for (const std::string& file : {options.plot, options.output}) require_free(file, options.force);
  Connection connection = program.connect();
  if (options.study.empty()) return begin(options, connection);
  const std::string id = resolve_study(connection, options.study);
  if (!options.no_wait) follow_with_progress(connection, id, "dccast design-recipe --study " + id);
  return print(connection, options, id);
}

constexpr const char* recipe_examples =
    R"(dccast design-recipe start-3d.toml --band "35..45 mm" -o chosen.toml --plot recipe.html
  dccast design-recipe my.toml --band "35..45 mm" --speed "35..65 mm/min" --water "60..200 l/min/m"
  dccast design-recipe --study ID --no-wait      what there is so far

Drafts over recipe and data, surfaces that propose, castings and a run at the quality of the
case that confirm (docs/recipe.md). The same command goes on with what is there. Exit code 3
when no recipe is confirmed.)";

}  // namespace

void add_design_mould(CommandLine& line, Program& program) {
  const auto [command, options] = declare<MouldOptions>(
      line, program, run, "design-mould",
      "Find the mould opening of three segments that gives a flat cold slab", mould_examples);

  command.option("CASE", options.base.file,
                 "Case file of a quarter slab that is cast until it is steady");
  command.flag("--flat", options.flat, "Find a cold slab that is flat along its wide face");
  command.option(
      "--tolerance", options.tolerance,
      "Largest permitted deviation of the half-thickness of the cold slab along the face", shown);
  command.option("--wanted", options.wanted,
                 "Half-thickness of the cold slab; absent: the half-opening of the case's mould at "
                 "its narrow face");
  command.number("--runs", options.most_runs, 0, 50, "Largest number of runs; 0 for 12");
  add_study_options(
      command, options,
      {.study = "Take this design up again",
       .plot = "Write an HTML page with mould and cold slab of the runs; - for standard output",
       .json = "As JSON, in metres, with every run"});
}

void add_design_recipe(CommandLine& line, Program& program) {
  const auto [command, options] = declare<RecipeOptions>(
      line, program, run, "design-recipe",
      "Find speed, filling, hold and water that keep the curl inside a band, whatever the data are",
      recipe_examples);

  RecipeChoice& choice = options.choice;
  command.option("CASE", options.base.file, "Case file whose recipe is changed");
  command.option("--band", choice.band,
                 "Curls that the plant accepts, as 35..45 mm; absent: those of the case");
  command.option("-o,--output", options.output, "Write the case with the chosen recipe");
  command.option("--speed", choice.speed, "Limits of the casting speed", shown);
  command.option("--speed-rate", choice.speed_rate, "Greatest rate of the speed", shown);
  command.option("--water", choice.water, "Limits of the water per metre of perimeter", shown);
  command.option("--water-rate", choice.water_rate, "Greatest rate of the water", shown);
  command.option("--hold", choice.hold, "Limits of the hold", shown);
  command.option("--filling", choice.filling, "Limits of the filling", shown);
  command.option("--ramp", choice.ramp, "Limits of the time of a ramp", shown);
  command.number("--within", choice.within_percent, 1, 90,
                 "Largest difference of the levels of speed and water from those of the case, "
                 "in percent");
  command.option("--point", choice.point, "Monitor; absent: output.curl, or the largest curl");
  command.option("--line", choice.line,
                 "Data that the castings of this line leave possible (dccast line add)");
  command.number("--drafts", choice.drafts, 12, 5000, "Drafts over recipe and data");
  command.number("--castings", choice.castings, 2, 200,
                 "Drafts over the data at each recipe, twice");
  command.number("--candidates", choice.candidates, 1, 10, "Recipes of the front");
  command.option("--seed", choice.seed, "Of all that is drawn", shown);

  add_study_options(command, options,
                    {.study = "Show this study",
                     .plot = "Write an HTML page; - for standard output",
                     .json = "As JSON, in SI units"});
}

}  // namespace dccast::client
