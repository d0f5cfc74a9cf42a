#include <unistd.h>

#include <iostream>

#include "client/cli/common_options.hpp"
#include "client/commands/commands.hpp"
#include "client/model/json.hpp"
#include "client/model/slab_recipe.hpp"
#include "client/session/failure.hpp"
#include "proto/case_file/alloy_cards.hpp"
#include "proto/case_file/shipped.hpp"
#include "proto/case_file/text_checks.hpp"

namespace dccast::client::commands {
namespace {

struct NewOptions {
  std::string name;
  SlabRecipe recipe;
  std::string output;
  bool force = false;
  bool list = false;
  bool json = false;
};

const std::string& text_of(const std::string& name) {
  if (const auto* shipped = shipped::find(shipped::case_templates(), name)) return shipped->text;
  const auto names = shipped::names_of(shipped::case_templates());
  const std::string near = case_file::nearest(name, names);
  std::string known;
  for (const std::string& one : names) known += " " + one;
  throw CommandFailed(ExitCode::not_found, "no case named '" + name + "'; " +
                                               (near.empty() ? "" : "did you mean " + near + "? ") +
                                               "there are:" + known);
}

/// The answer on the terminal; an empty line is the one in brackets. Throws CommandFailed at the
/// end of the input.
std::string asked(const std::string& question, const std::string& usual) {
  std::cerr << question << " [" << usual << "]: " << std::flush;
  std::string answer;
  if (!std::getline(std::cin, answer))
    throw CommandFailed(ExitCode::invalid, "no answer; give --slab, or the name of a shipped case");
  return answer.empty() ? usual : answer;
}

/// Asks for what the options would give. An answer at fault is asked for again.
void ask(NewOptions& options) {
  std::string alloys;
  for (const std::string& name : case_file::alloy_names()) alloys += " " + name;
  std::cerr << "A case for the start of a slab. Shipped cases: dccast new --list\n";
  NewCase made;
  do {
    for (const std::string& fault : made.faults) std::cerr << fault << '\n';
    options.recipe.slab = asked("Slab, width x thickness", "1320x570mm");
    options.recipe.alloy = asked("Alloy, one of" + alloys, "aa5182");
    options.recipe.speed = asked("Casting speed, start..steady", "40..60mm/min");
    options.recipe.water =
        asked("Water, in all (m3/h) or per metre of perimeter (l/min/m)", "90..180l/min/m");
    made = new_case(options.recipe);
  } while (!made.faults.empty());
  if (options.output.empty()) options.output = asked("File to write, - for the screen", "my.toml");
}

/// The text of the recipe's case; what it is goes to standard error.
std::string slab_text(const SlabRecipe& recipe) {
  const NewCase made = new_case(recipe);
  std::string faults;
  for (const std::string& fault : made.faults) faults += (faults.empty() ? "" : "\n") + fault;
  if (!faults.empty()) throw CommandFailed(ExitCode::invalid, faults);
  std::cerr << made.summary << '\n';
  return made.text;
}

bool on_terminal() {
  return ::isatty(STDIN_FILENO) == 1 && ::isatty(STDERR_FILENO) == 1;
}

void list_names(bool json) {
  if (json) std::cout << Json(shipped::names_of(shipped::case_templates())).dump() << '\n';
  if (!json)
    for (const std::string& name : shipped::names_of(shipped::case_templates()))
      std::cout << name << '\n';
}

ExitCode run(NewOptions options) {
  const bool undecided = options.name.empty() && options.recipe.slab.empty();
  const SlabRecipe& recipe = options.recipe;
  if (recipe.slab.empty() && !(recipe.alloy + recipe.speed + recipe.water).empty())
    throw CommandFailed(ExitCode::invalid, "--alloy, --speed and --water belong to --slab");
  if (!options.name.empty() && !recipe.slab.empty())
    throw CommandFailed(ExitCode::invalid, "give the name of a shipped case or --slab, not both");
  if (options.list || (undecided && (options.json || !on_terminal()))) {
    list_names(options.json);
    return ExitCode::done;
  }
  if (undecided) ask(options);
  const std::string text = recipe.slab.empty() ? text_of(options.name) : slab_text(recipe);
  const bool to_screen = options.output.empty() || options.output == "-";
  if (!to_screen) require_free(options.output, options.force);
  if (options.json) {
    std::cout << Json{{"name", options.name + recipe.slab}, {"text", text}}.dump() << '\n';
  } else if (to_screen) {
    std::cout << text;
  } else {
    write_file(options.output, text);
  }
  return ExitCode::done;
}

}  // namespace

void add_new(cli::CommandLine& line, Program&) {
  const auto options = std::make_shared<NewOptions>();
  const cli::Command command = line.command(
      "new", "Write a case file to begin with: a shipped case, or the start of a slab of your own",
      "dccast new start-2d-thickness > my.toml\n"
      "  dccast new --slab 1320x570mm --alloy aa5182 --speed 45..55mm/min --water 25..45m3/h --out "
      "my.toml\n  dccast new        # asks for the same");
  command.option("NAME", options->name, "Name of a shipped case");
  command.option("--slab", options->recipe.slab, "Width x thickness of a slab, e.g. 1320x570mm");
  command.option("--alloy", options->recipe.alloy, "Of the slab: name of a card (dccast alloys)");
  command.option("--speed", options->recipe.speed,
                 "Of the slab: casting speed, start..steady, e.g. 45..55mm/min");
  command.option("--water", options->recipe.water,
                 "Of the slab: water in all, e.g. 25..45m3/h, or per metre of perimeter, e.g. "
                 "90..180l/min/m");
  command.option("-o,--output,--out", options->output, "File to write instead of standard output");
  add_force_flag(command, options->force);
  command.flag("--list", options->list, "List the names");
  command.json(options->json);
  command.action([options] { return run(*options); });
}

}  // namespace dccast::client::commands
