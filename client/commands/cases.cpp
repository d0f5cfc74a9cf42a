#include <unistd.h>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>

#include "client/cli/common_options.hpp"
#include "client/commands/commands.hpp"
#include "client/html/pages.hpp"
#include "client/model/alloy_table.hpp"
#include "client/model/answer.hpp"
#include "client/session/case_faults.hpp"
#include "client/text/findings.hpp"
#include "client/text/progress.hpp"
#include "client/text/table.hpp"
#include "client/text/terminal.hpp"
#include "dccast/v1/config.pb.h"
#include "proto/case_file/alloy_cards.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/plant_words.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/case_file/shipped.hpp"
#include "proto/case_file/slab_recipe.hpp"
#include "proto/case_file/text_checks.hpp"
#include "proto/figures/rounding.hpp"

namespace dccast::client {
namespace {

using case_file::NewCase, case_file::new_case, case_file::SlabRecipe;

struct NewOptions {
  std::string name;
  SlabRecipe recipe;
  std::string output;
  bool force = false;
  bool list = false;
  bool check = false;
  bool json = false;
};

const std::string& text_of(const std::string& name) {
  if (const auto* shipped = shipped::find(shipped::case_templates(), name)) return shipped->text;
  const auto names = shipped::names_of(shipped::case_templates());
  const std::string near = case_file::nearest(name, names);
  std::string known;
  for (const std::string& case_name : names) known += " " + case_name;
  throw CommandFailed(ExitCode::not_found, "no case named '" + name + "'; " +
                                               (near.empty() ? "" : "did you mean " + near + "? ") +
                                               "there are:" + known);
}

/// Reads an answer from the terminal; an empty line chooses the one in brackets. Throws
/// CommandFailed at the end of the input.
std::string asked(const std::string& question, const std::string& usual) {
  std::cerr << question << " [" << usual << "]: " << std::flush;
  std::string answer;
  if (!std::getline(std::cin, answer))
    throw invalid("no answer; give --slab, or the name of a shipped case");
  return answer.empty() ? usual : answer;
}

bool on_terminal() {
  return ::isatty(STDIN_FILENO) == 1 && ::isatty(STDERR_FILENO) == 1;
}

/// Repeats a question until the answer fits the earlier ones. @param answer  part of the recipe to
/// which the question belongs
void ask_for(std::string& answer, const SlabRecipe& recipe, const std::string& question,
             const std::string& usual) {
  while (true) {
    answer = asked(question, usual);
    const std::vector<std::string> faults = new_case(recipe).faults;
    if (faults.empty()) return;
    for (const std::string& fault : faults) std::cerr << fault << '\n';
  }
}

/// A script is told what it gets instead.
void ask_for_alloy(SlabRecipe& recipe) {
  std::string alloys;
  for (const std::string& name : case_file::alloy_names()) alloys += " " + name;
  if (on_terminal())
    ask_for(recipe.alloy, recipe, "Alloy, a card file or one of" + alloys, "aa5182");
  else
    std::cerr << "no --alloy is given: that of the shipped case; there are" << alloys << '\n';
}

/// Asks for everything that the options could give. Only a wrong answer is asked for again.
void ask(NewOptions& options) {
  std::cerr << "A case for the start of a slab. Shipped cases: dccast new --list\n";

  SlabRecipe& recipe = options.recipe;
  ask_for(recipe.slab, recipe, "Slab, width x thickness", "1320x570mm");
  ask_for_alloy(recipe);
  ask_for(recipe.speed, recipe, "Casting speed, start..steady", "40..60mm/min");
  ask_for(recipe.water, recipe, "Water, in all (m3/h) or per metre of perimeter (l/min/m)",
          "90..180l/min/m");
  if (options.output.empty()) options.output = asked("File to write, - for the screen", "my.toml");
}

/// Text of the recipe's case; a summary goes to standard error.
std::string slab_text(const SlabRecipe& recipe) {
  const NewCase made = new_case(recipe);
  std::string faults;
  for (const std::string& fault : made.faults) faults += (faults.empty() ? "" : "\n") + fault;
  if (!faults.empty()) throw invalid(faults);
  std::cerr << made.summary << '\n';
  return made.text;
}

void list_names(bool json) {
  if (json) std::cout << Json(shipped::names_of(shipped::case_templates())).dump() << '\n';
  if (!json)
    for (const std::string& name : shipped::names_of(shipped::case_templates()))
      std::cout << name << '\n';
}

ExitCode run(const NewOptions& given, Program& program) {
  NewOptions options = given;
  const std::string size = options.recipe.slab + options.recipe.billet;  // of which one is empty
  const bool undecided = options.name.empty() && size.empty();
  const SlabRecipe& recipe = options.recipe;

  if (size.empty() && !(recipe.alloy + recipe.speed + recipe.water).empty())
    throw invalid("--alloy, --speed and --water belong to --slab or --billet");
  if (!options.name.empty() && !size.empty())
    throw invalid("give the name of a shipped case or --slab, not both");

  // A script is not asked; it gets the names that it could have given.
  if (options.list || (undecided && (options.json || !on_terminal()))) {
    list_names(options.json);
    return ExitCode::done;
  }
  if (undecided) ask(options);
  if (!size.empty() && recipe.alloy.empty()) ask_for_alloy(options.recipe);

  const std::string text = options.name.empty() ? slab_text(recipe) : text_of(options.name);
  const bool to_screen = options.output.empty() || options.output == "-";
  if (options.check && to_screen)
    throw invalid("--check computes the case that it wrote: give --out FILE");

  require_free(options.output, options.force);
  if (options.json) {
    print_line({{"name", options.name + size}, {"text", text}});
  } else if (to_screen) {
    std::cout << text;
  } else {
    write_file(options.output, text);
  }
  return options.check ? check_by_draft(options.output, program) : ExitCode::done;
}

struct ValidateOptions {
  std::string file;
  std::vector<std::string> set;
  bool local = false;
  bool json = false;
  bool strict = false;
  bool ranges = false;
  std::string drawing;  ///< HTML page to be written; empty: none
  bool force = false;
};

/// "no faults, 1 danger, 2 warnings".
std::string verdict_text(const CaseUnderCheck& checked) {
  std::string text = "no faults";
  for (const auto& [severity, name] :
       {std::pair(v1::Finding::DANGER, " danger"), {v1::Finding::WARNING, " warning"}}) {
    const auto count = std::ranges::count(checked.findings, severity, &v1::Finding::severity);
    if (count > 0) text += ", " + std::to_string(count) + name + (count == 1 ? "" : "s");
  }
  return text;
}

/// The case with the defaults that the server would add; nothing if it cannot be read.
std::optional<v1::Case> complete_case(const CaseUnderCheck& checked) {
  if (!checked.read.ok()) return std::nullopt;
  v1::Case complete = checked.description;
  case_file::apply_defaults(complete);
  return complete;
}

/// Whether the curls of the run will have an error bar.
std::string band_text(const v1::Case& complete) {
  const auto error = case_file::relative_discretisation_error(complete);
  if (!error)
    return "its curls will have no error bar: none was measured for such a casting or mesh "
           "(docs/error-bars.md)";
  constexpr double in_percent = 100.0;
  return "its curls will have an error bar of " +
         figures::errors_text(in_percent * error->lower(), in_percent * error->upper(), 0) +
         " % for mesh and steps (docs/error-bars.md)";
}

void print_verdict(const CaseUnderCheck& checked, bool local) {
  const bool may_end_early = checked.description.time().has_settled_m_per_s();
  if (!checked.faults.empty())
    std::cerr << checked.faults.size() << (checked.faults.size() == 1 ? " fault\n" : " faults\n");
  else if (checked.estimate)
    std::cout << verdict_text(checked) << ": " << checked.estimate->nodes() << " nodes, "
              << checked.estimate->elements() << " elements, " << checked.estimate->steps()
              << " steps, " << (may_end_early ? "at most " : "about ")
              << duration_text(checked.estimate->solver_s()) << " of computing\n"
              << checked.uncertain.size() << " data have a range (--ranges, docs/uncertainty.md)\n";
  else
    std::cout << (local ? "no faults found without a server" : verdict_text(checked)) << '\n';
}

void print_ranges(const CaseUnderCheck& checked) {
  Table table({"DATUM", "RANGE", "GIVEN BY"});
  for (const case_file::UncertainKey& datum : checked.uncertain)
    table.add({datum.key, datum.range, datum.origin});
  std::cout << table.text();
}

ExitCode run(const ValidateOptions& options, Program& program) {
  CaseUnderCheck checked = read_case(options.file, changes_of(options.set));
  require_free(options.drawing, options.force);
  if (!options.local) {
    Connection connection = program.connect();
    check_with_server(checked, connection);
  }

  const std::optional<v1::Case> complete = complete_case(checked);
  if (options.json) {
    Json json = faults_json(checked);
    if (complete) json["casting"] = case_file::casting_summary(*complete);
    if (complete && checked.faults.empty())
      json["has_error_bar"] = case_file::relative_discretisation_error(*complete).has_value();
    print_line(json);
  } else {
    if (complete) std::cout << case_file::casting_summary(*complete) << '\n';
    print_faults(checked, std::cout);
    for (const v1::Finding& finding : checked.findings) std::cout << finding_line(finding) << '\n';
    if (options.ranges) print_ranges(checked);
    print_verdict(checked, options.local);
    if (complete && checked.faults.empty()) std::cout << band_text(*complete) << '\n';
  }

  if (complete && !options.drawing.empty()) write_output(options.drawing, casting_page(*complete));
  const bool implausible = options.strict && more_than_notes(checked.findings);
  return checked.faults.empty() && !implausible ? ExitCode::done : ExitCode::invalid;
}

struct SchemaOptions {
  std::string prefix;
  bool daemon = false;
  bool json = false;
};

using case_file::KeyReference;

std::string kind_text(const KeyReference& row) {
  std::string text = row.type;
  if (!row.unit.empty() && row.unit != "1") text += " [" + row.unit + "]";
  if (row.curve) text += ", or a table against " + row.against + " of " + row.size;
  return text;
}

void print(const KeyReference& row, const Terminal& terminal) {
  const bool list = row.path.ends_with("[]");
  if (row.type == "table") {
    std::string header = row.path;
    // Headers of TOML name a list in a list without brackets of its own: [[a.b]].
    for (auto at = header.find("[]"); at != std::string::npos; at = header.find("[]"))
      header.erase(at, 2);
    std::cout << '\n'
              << bold(list ? "[[" + header + "]]" : "[" + header + "]", terminal) << "  " << row.doc
              << (row.size.empty() ? "" : "; " + row.size) << '\n';
    return;
  }
  std::cout << "  " << bold(row.path, terminal) << (row.required ? "  (required)" : "")
            << "\n      " << row.doc << "\n      " << kind_text(row);
  if (!row.permitted.empty()) std::cout << "; " << row.permitted;
  if (!row.size.empty() && !row.curve) std::cout << "; " << row.size;
  if (!row.default_text.empty()) std::cout << "; default " << row.default_text;
  if (!row.uncertainty.empty()) std::cout << "; uncertain " << row.uncertainty;
  std::cout << '\n';
}

Json row_json(const KeyReference& row) {
  return {{"path", row.path},
          {"type", row.type},
          {"unit", row.unit},
          {"permitted", row.permitted},
          {"size", row.size},
          {"curve", row.curve},
          {"against", row.against},
          {"required", row.required},
          {"default", row.default_text},
          {"uncertainty", row.uncertainty},
          {"doc", row.doc}};
}

ExitCode run(const SchemaOptions& options, Program&) {
  const auto& descriptor =
      options.daemon ? *v1::DaemonConfig::descriptor() : *v1::Case::descriptor();

  Json list = Json::array();
  bool found = false;
  const Terminal terminal = terminal_of(1);
  for (const KeyReference& row : case_file::reference(descriptor)) {
    // Any part of a path will do: users know a key, not its table.
    if (row.path.find(options.prefix) == std::string::npos) continue;
    found = true;
    if (options.json)
      list.push_back(row_json(row));
    else
      print(row, terminal);
  }

  if (!found)
    throw CommandFailed(ExitCode::not_found,
                        "no key of a case has '" + options.prefix + "' in its path");
  if (options.json) print_line(list);
  return ExitCode::done;
}

struct AlloysOptions {
  std::string name;
  std::string table;
  bool local = false;
  bool json = false;
};

std::vector<v1::Alloy> shipped_alloys() {
  std::vector<v1::Alloy> alloys;
  for (const std::string& name : case_file::alloy_names())
    alloys.push_back(case_file::alloy_card(name).alloy);
  return alloys;
}

std::vector<v1::Alloy> alloys_of(const AlloysOptions& options, Program& program) {
  if (options.local) return shipped_alloys();
  Connection connection = program.connect();
  v1::ListAlloysResponse response;
  // Added once: the shipped cards are available without a server.
  const grpc::Status status =
      connection.try_once(&Stub::ListAlloys, v1::ListAlloysRequest(), response);
  if (status.ok()) return {response.alloys().begin(), response.alloys().end()};
  std::cerr << "dccast: " << failure_of(status, connection.server()).what()
            << "; these are the shipped cards\n";
  return shipped_alloys();
}

void add_table(const std::string& file, v1::Alloy& card) {
  std::ifstream stream(file);
  if (!stream) throw CommandFailed(ExitCode::invalid, file + ": cannot be read");
  const auto faults = read_alloy_table(stream, file, card);
  if (!faults.empty())
    throw CommandFailed(ExitCode::invalid, fmt::format("{}", fmt::join(faults, "\n")));
  card.set_provenance("indicative, with data of " +
                      std::filesystem::path(file).filename().string());
}

ExitCode print_one(const std::vector<v1::Alloy>& alloys, const AlloysOptions& options) {
  const auto alloy = std::ranges::find(alloys, options.name, &v1::Alloy::card);
  if (alloy == alloys.end())
    throw CommandFailed(ExitCode::not_found,
                        "no alloy card named '" + options.name + "'; see `dccast alloys`");
  v1::Alloy card = *alloy;
  if (!options.table.empty()) add_table(options.table, card);
  std::cout << (options.json ? to_json(card).dump() + "\n" : case_file::to_toml(card));
  return ExitCode::done;
}

ExitCode run(const AlloysOptions& options, Program& program) {
  const auto alloys = alloys_of(options, program);
  if (!options.name.empty()) return print_one(alloys, options);
  Json list = Json::array();
  Table table({"CARD", ">SOLIDUS °C", ">LIQUIDUS °C", "PROVENANCE", "DESCRIPTION"});
  for (const v1::Alloy& alloy : alloys) {
    list.push_back(to_json(alloy));
    table.add({alloy.card(), fixed(alloy.solidus_c(), 1), fixed(alloy.liquidus_c(), 1),
               alloy.provenance(), alloy.description()});
  }
  std::cout << (options.json ? list.dump() + "\n" : table.text());
  return ExitCode::done;
}

}  // namespace

void add_new(CommandLine& line, Program& program) {
  const auto [command, options] = declare<NewOptions>(
      line, program, run, "new",
      "Write a case file to begin with: a shipped case, or the start of a slab of your own",
      "dccast new start-2d-thickness > my.toml\n"
      "  dccast new --slab 1320x570mm --alloy aa5182 --speed 45..55mm/min --water 25..45m3/h --out "
      "my.toml\n  dccast new --slab 1860x510mm --alloy aa1050 --out my.toml --check\n"
      "  dccast new        # asks for the same");

  command.option("NAME", options.name, "Name of a shipped case");
  command.option("--slab", options.recipe.slab, "Sides of a slab, e.g. 1320x570mm");
  command.option("--billet", options.recipe.billet,
                 "In place of --slab: diameter of a round billet, e.g. 203mm",
                 {.excludes = {"--slab"}});
  command.option("--alloy", options.recipe.alloy,
                 "Of the slab: name of a card (dccast alloys), or a file with your own");
  command.option("--speed", options.recipe.speed,
                 "Of the slab: casting speed, start..steady, e.g. 45..55mm/min");
  command.option(
      "--water", options.recipe.water,
      "Of the slab: water in all, e.g. 25..45m3/h, or per metre of perimeter, e.g. 90..180l/min/m");
  command.option("-o,--output,--out", options.output, "File to write instead of standard output");
  add_force_flag(command, options.force);
  command.flag("--check", options.check,
               "Compute the case at draft, and print its curl and what a plant would find");
  command.flag("--list", options.list, "List the names");
  command.json(options.json);
}

void add_validate(CommandLine& line, Program& program) {
  const auto [command, options] = declare<ValidateOptions>(
      line, program, run, "validate",
      "Check a case file: list all faults, and findings on whether a plant could cast it",
      "dccast validate my.toml\n  dccast validate --set mesh.rows=30 my.toml");
  command.option("FILE", options.file, "Case file; - for standard input", required);
  add_set_option(command, options.set);
  command.flag("--local", options.local,
               "Do not ask the server: check keys, units and ranges only");
  command.flag("--ranges", options.ranges, "List the data with a range (docs/uncertainty.md)");
  command.option("--drawing", options.drawing,
                 "Also write this HTML page: a drawing of mould, water line, block, and the ramps");
  add_force_flag(command, options.force);
  command.flag("--strict", options.strict,
               "Exit code 2 also for findings beyond notes (docs/findings.md)");
  command.json(options.json);
}

void add_schema(CommandLine& line, Program& program) {
  const auto [command, options] =
      declare<SchemaOptions>(line, program, run, "schema",
                             "Reference of every key of a case file: unit, range, default, meaning",
                             "dccast schema cooling.water");
  command.option("PART", options.prefix, "Only keys with this in their path");
  command.flag("--daemon", options.daemon, "Keys of the daemon's configuration instead");
  command.json(options.json);
}

void add_alloys(CommandLine& line, Program& program) {
  const auto [command, options] = declare<AlloysOptions>(
      line, program, run, "alloys", "List the alloy cards, or print one as TOML",
      "dccast alloys\n  dccast alloys aa5182 --table measured.csv > my-alloy.toml");
  command.option("CARD", options.name, "Print this card");
  command.option("--table", options.table,
                 "Of that card: put in what this CSV has over temperature (docs/alloys.md)",
                 {.placeholder = "FILE"});
  command.flag("--local", options.local, "Do not ask the server: shipped cards only");
  command.json(options.json);
}

}  // namespace dccast::client
