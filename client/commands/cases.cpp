#include <algorithm>
#include <iostream>

#include "client/cli/common_options.hpp"
#include "client/commands/commands.hpp"
#include "client/html/pages.hpp"
#include "client/model/answer.hpp"
#include "client/model/json.hpp"
#include "client/session/case_faults.hpp"
#include "client/text/findings.hpp"
#include "client/text/plant_units.hpp"
#include "client/text/progress.hpp"
#include "client/text/table.hpp"
#include "client/text/terminal.hpp"
#include "dccast/v1/config.pb.h"
#include "proto/case_file/alloy_cards.hpp"
#include "proto/case_file/case_file.hpp"

namespace dccast::client::commands {
namespace {

struct ValidateOptions {
  std::string file;
  std::vector<std::string> set;
  bool local = false;
  bool json = false;
  bool strict = false;
  bool ranges = false;
  std::string drawing;  ///< SVG file
  bool force = false;
};

/// "no faults, 1 danger, 2 warnings".
std::string verdict_of(const CaseUnderCheck& checked) {
  std::string text = "no faults";
  for (const auto& [severity, name] :
       {std::pair(v1::Finding::DANGER, " danger"), {v1::Finding::WARNING, " warning"}}) {
    const auto count = std::ranges::count(checked.findings, severity, &v1::Finding::severity);
    if (count > 0) text += ", " + std::to_string(count) + name + (count == 1 ? "" : "s");
  }
  return text;
}

/// The case with the defaults that the server would fill in.
v1::Case complete_case(const CaseUnderCheck& checked) {
  v1::Case complete = checked.description;
  case_file::apply_defaults(complete);
  return complete;
}

/// Of a case whose keys could all be read.
void write_drawing(const ValidateOptions& options, const CaseUnderCheck& checked) {
  if (options.drawing.empty() || !checked.read.ok()) return;
  write_output(options.drawing, render::casting_drawing(complete_case(checked)));
}

void print_verdict(const CaseUnderCheck& checked, bool local) {
  if (!checked.faults.empty())
    std::cerr << checked.faults.size() << (checked.faults.size() == 1 ? " fault\n" : " faults\n");
  else if (checked.estimate)
    std::cout << verdict_of(checked) << ": " << checked.estimate->nodes() << " nodes, "
              << checked.estimate->elements() << " elements, " << checked.estimate->steps()
              << " steps, about " << render::duration_text(checked.estimate->solver_s())
              << " of computing\n"
              << checked.uncertain.size() << " data have a range (--ranges, docs/uncertainty.md)\n";
  else
    std::cout << (local ? "no faults found without a server" : verdict_of(checked)) << '\n';
}

void print_ranges(const CaseUnderCheck& checked) {
  render::Table table({"DATUM", "RANGE", "GIVEN BY"});
  for (const case_file::UncertainKey& datum : checked.uncertain)
    table.add({datum.key, datum.range, datum.origin});
  std::cout << table.text();
}

ExitCode run(const ValidateOptions& options, Program& program) {
  CaseUnderCheck checked = read_case(options.file, changes_of(options.set));
  if (!options.drawing.empty()) require_free(options.drawing, options.force);
  if (!options.local) {
    Connection connection = program.connect();
    check_with_server(checked, connection);
  }
  if (options.json) {
    Json json = faults_json(checked);
    if (checked.read.ok()) json["casting"] = render::casting_summary(complete_case(checked));
    std::cout << json.dump() << '\n';
  } else {
    if (checked.read.ok()) std::cout << render::casting_summary(complete_case(checked)) << '\n';
    print_faults(checked, std::cout);
    for (const v1::Finding& finding : checked.findings)
      std::cout << render::finding_line(finding) << '\n';
    if (options.ranges) print_ranges(checked);
    print_verdict(checked, options.local);
  }
  write_drawing(options, checked);
  const bool implausible = options.strict && render::more_than_notes(checked.findings);
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

void print(const KeyReference& row, const render::Terminal& terminal) {
  const bool list = row.path.ends_with("[]");
  if (row.type == "table") {
    std::string header = row.path;
    for (auto at = header.find("[]"); at != std::string::npos; at = header.find("[]"))
      header.erase(at, 2);
    std::cout << '\n'
              << render::bold(list ? "[[" + header + "]]" : "[" + header + "]", terminal) << "  "
              << row.doc << (row.size.empty() ? "" : "; " + row.size) << '\n';
    return;
  }
  std::cout << "  " << render::bold(row.path, terminal) << (row.required ? "  (required)" : "")
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

ExitCode run(const SchemaOptions& options) {
  const auto& descriptor =
      options.daemon ? *v1::DaemonConfig::descriptor() : *v1::Case::descriptor();
  Json list = Json::array();
  bool found = false;
  const render::Terminal terminal = render::terminal_of(1);
  for (const KeyReference& row : case_file::reference(descriptor)) {
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
  if (options.json) std::cout << list.dump() << '\n';
  return ExitCode::done;
}

struct AlloysOptions {
  std::string name;
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
  connection.set_policy({.attempts = 1});  // the shipped cards are available without the server
  v1::ListAlloysResponse response;
  const grpc::Status status =
      connection.try_call(&Stub::ListAlloys, v1::ListAlloysRequest(), response);
  if (status.ok()) return {response.alloys().begin(), response.alloys().end()};
  std::cerr << "dccast: " << failure_of(status, connection.server()).what()
            << "; these are the shipped cards\n";
  return shipped_alloys();
}

ExitCode print_one(const std::vector<v1::Alloy>& alloys, const AlloysOptions& options) {
  for (const v1::Alloy& alloy : alloys) {
    if (alloy.card() != options.name) continue;
    std::cout << (options.json ? to_json(alloy).dump() + "\n" : case_file::to_toml(alloy));
    return ExitCode::done;
  }
  throw CommandFailed(ExitCode::not_found,
                      "no alloy card named '" + options.name + "'; see `dccast alloys`");
}

ExitCode run(const AlloysOptions& options, Program& program) {
  const auto alloys = alloys_of(options, program);
  if (!options.name.empty()) return print_one(alloys, options);
  Json list = Json::array();
  render::Table table({"CARD", ">SOLIDUS °C", ">LIQUIDUS °C", "PROVENANCE", "DESCRIPTION"});
  for (const v1::Alloy& alloy : alloys) {
    list.push_back(to_json(alloy));
    table.add({alloy.card(), render::fixed(alloy.solidus_c(), 1),
               render::fixed(alloy.liquidus_c(), 1), alloy.provenance(), alloy.description()});
  }
  std::cout << (options.json ? list.dump() + "\n" : table.text());
  return ExitCode::done;
}

}  // namespace

void add_validate(cli::CommandLine& line, Program& program) {
  const auto options = std::make_shared<ValidateOptions>();
  const cli::Command command =
      line.command("validate",
                   "Check a case file: list everything that is wrong with it, and findings on "
                   "whether a plant could cast it",
                   "dccast validate my.toml\n  dccast validate --set mesh.rows=30 my.toml");
  command.option("FILE", options->file, "Case file; - for standard input").required();
  add_set_option(command, options->set);
  command.flag("--local", options->local,
               "Do not ask the server: check keys, units and ranges only");
  command.flag("--ranges", options->ranges, "List the data with a range (docs/uncertainty.md)");
  command.option("--drawing", options->drawing,
                 "Also write this SVG file: mould, water line, block, and the ramps");
  add_force_flag(command, options->force);
  command.flag("--strict", options->strict,
               "Exit code 2 for findings beyond notes too (docs/findings.md)");
  command.json(options->json);
  command.action([options, &program] { return run(*options, program); });
}

void add_schema(cli::CommandLine& line, Program&) {
  const auto options = std::make_shared<SchemaOptions>();
  const cli::Command command =
      line.command("schema", "Reference of every key of a case file: unit, range, default, meaning",
                   "dccast schema cooling.water");
  command.option("PART", options->prefix, "Only keys with this in their path");
  command.flag("--daemon", options->daemon, "Keys of the daemon's configuration instead");
  command.json(options->json);
  command.action([options] { return run(*options); });
}

void add_alloys(cli::CommandLine& line, Program& program) {
  const auto options = std::make_shared<AlloysOptions>();
  const cli::Command command =
      line.command("alloys", "List the alloy cards, or print one as TOML",
                   "dccast alloys\n  dccast alloys aa5182 > my-alloy.toml");
  command.option("CARD", options->name, "Print this card");
  command.flag("--local", options->local, "Do not ask the server: shipped cards only");
  command.json(options->json);
  command.action([options, &program] { return run(*options, program); });
}

}  // namespace dccast::client::commands
