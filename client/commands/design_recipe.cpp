#include <iostream>

#include "client/cli/common_options.hpp"
#include "client/commands/commands.hpp"
#include "client/html/pages.hpp"
#include "client/model/answer.hpp"
#include "client/model/json.hpp"
#include "client/session/case_faults.hpp"
#include "client/session/recipe_study.hpp"
#include "client/session/studies.hpp"
#include "client/text/data_study_text.hpp"
#include "client/text/plant_units.hpp"
#include "proto/case_file/override.hpp"

namespace dccast::client::commands {
namespace {

struct Options : StudyOptions {
  RecipeChoice choice;
  std::string output;
};

/// The case as its file has it, with what the chosen recipe changes.
void write_chosen(const Options& options, const v1::RecipeFound& found) {
  if (found.chosen() < 0) {
    std::cerr << options.output << " is not written: no recipe is confirmed\n";
    return;
  }
  CaseUnderCheck chosen = read_case(options.base.file, changes_of(options.base.set));
  const auto& changes = found.front(found.chosen()).changes();
  case_file::apply_changes(chosen.description, {changes.begin(), changes.end()});
  write_output(options.output, render::readable_toml(chosen.description));
}

ExitCode print(Connection& connection, const Options& options, const std::string& id) {
  const v1::StudyResult result = evaluate_study(connection, id);
  if (!result.study().has_recipe())
    throw CommandFailed(
        ExitCode::invalid,
        "study " + id + " designs no recipe; dccast studies show " + id + " shows what it is");
  if (!options.output.empty()) write_chosen(options, result.recipe());
  if (!options.plot.empty()) write_output(options.plot, render::recipe_page(result));
  if (options.json)
    std::cout << to_json(result).dump() << '\n';
  else if (options.plot != "-" && options.output != "-")
    std::cout << render::recipe_text(result);
  std::cout << std::flush;
  const bool open = result.study().state() == v1::STUDY_RUNNING;
  return open || result.recipe().chosen() >= 0 ? ExitCode::done : ExitCode::solve_failed;
}

/// Follows a study of this command's own, which ends with it.
void follow_own(Connection& connection, const std::string& id) {
  try {
    follow_with_progress(connection, id, {});
  } catch (const Interrupted&) {
    cancel_after_interruption(connection, id);
    throw Interrupted("study " + id + " is cancelled; the same command goes on with it");
  }
}

ExitCode begin(const Options& options, Connection& connection) {
  const auto created = create_study(connection, options.base, [&](v1::CreateStudyRequest& request) {
    lay_out_recipe(connection, options.choice, request);
  });
  if (!created) return ExitCode::invalid;
  const v1::Study study = taken_up(connection, *created);
  std::cerr << "study " << study.id() << ", " << study.recipe().numbers_size() << " numbers and "
            << study.recipe().data_size()
            << " data; Ctrl-C cancels it, the same command goes on with it\n";
  if (options.no_wait) {
    std::cout << study.id() << std::endl;
    return ExitCode::done;
  }
  follow_own(connection, study.id());
  return print(connection, options, study.id());
}

ExitCode run(const Options& options, Program& program) {
  if (options.base.file.empty() == options.study.empty())
    throw CommandFailed(ExitCode::invalid,
                        "give a CASE to begin or to go on, or --study ID to show one");
  if (!options.output.empty() && options.base.file.empty())
    throw CommandFailed(ExitCode::invalid, "-o writes the CASE with its recipe: give it too");
  for (const std::string& file : {options.plot, options.output})
    if (!file.empty() && file != "-") require_free(file, options.force);
  Connection connection = program.connect();
  if (options.study.empty()) return begin(options, connection);
  const std::string id = resolve_study(connection, options.study);
  if (!options.no_wait) follow_with_progress(connection, id, "dccast design-recipe --study " + id);
  return print(connection, options, id);
}

constexpr const char* examples =
    "dccast design-recipe start-3d.toml --band \"35..45 mm\" -o chosen.toml --plot recipe.html\n"
    "  dccast design-recipe my.toml --band \"35..45 mm\" --speed \"35..65 mm/min\" --water "
    "\"60..200 "
    "l/min/m\"\n"
    "  dccast design-recipe --study ID --no-wait      what there is so far\n"
    "\n"
    "Drafts over recipe and data, surfaces that propose, castings and a run at the quality of the\n"
    "case that confirm (docs/recipe.md). The same command goes on with what is there. Exit code 3\n"
    "when no recipe is confirmed.";

void add_limits(const cli::Command& command, RecipeChoice& choice) {
  command.option("--speed", choice.speed, "Limits of the casting speed").show_default();
  command.option("--speed-rate", choice.speed_rate, "Greatest rate of the speed").show_default();
  command.option("--water", choice.water, "Limits of the water per metre of perimeter")
      .show_default();
  command.option("--water-rate", choice.water_rate, "Greatest rate of the water").show_default();
  command.option("--hold", choice.hold, "Limits of the hold").show_default();
  command.option("--filling", choice.filling, "Limits of the filling").show_default();
  command.option("--ramp", choice.ramp, "Limits of the time of a ramp").show_default();
  command
      .option("--within", choice.within_percent,
              "Levels of speed and water are within this of those of the case, in percent")
      .between(1, 90)
      .show_default();
}

void add_search(const cli::Command& command, RecipeChoice& choice) {
  command.option("--point", choice.point, "Monitor; absent: that with the largest curl");
  command.option("--drafts", choice.drafts, "Drafts over recipe and data")
      .between(12, 5000)
      .show_default();
  command.option("--castings", choice.castings, "Drafts over the data at each recipe, twice")
      .between(2, 200)
      .show_default();
  command.option("--candidates", choice.candidates, "Recipes of the front")
      .between(1, 10)
      .show_default();
  command.option("--seed", choice.seed, "Of all that is drawn").show_default();
}

}  // namespace

void add_design_recipe(cli::CommandLine& line, Program& program) {
  const auto options = std::make_shared<Options>();
  const cli::Command command = line.command(
      "design-recipe",
      "Find speed, filling, hold and water that keep the curl inside a band, whatever the data are",
      examples);
  command.option("CASE", options->base.file, "Case file whose recipe is changed");
  command.option("--band", options->choice.band,
                 "Curls that the plant accepts, as 35..45 mm; absent: those of the case");
  command.option("-o,--output", options->output, "Write the case with the chosen recipe");
  add_limits(command, options->choice);
  add_search(command, options->choice);
  add_study_options(command, *options,
                    {.study = "Show this study",
                     .plot = "Write an HTML page; - for standard output",
                     .json = "As JSON, in SI units"});
  command.action([options, &program] { return run(*options, program); });
}

}  // namespace dccast::client::commands
