#include <fstream>
#include <iostream>

#include "client/commands/commands.hpp"
#include "client/commands/output_file.hpp"
#include "client/message_json.hpp"
#include "proto/case_file/shipped.hpp"
#include "proto/case_file/text_checks.hpp"

namespace dccast::client::commands {
namespace {

struct Options {
  std::string name;
  std::string output;
  bool force = false;
  bool list = false;
  bool json = false;
};

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const auto& shipped : shipped::case_templates()) all.push_back(shipped.name);
  return all;
}

const std::string& text_of(const std::string& name) {
  for (const auto& shipped : shipped::case_templates())
    if (shipped.name == name) return shipped.text;
  const std::string near = case_file::nearest(name, names());
  std::string known;
  for (const std::string& one : names()) known += " " + one;
  throw CommandFailed(ExitCode::not_found, "no case named '" + name + "'; " +
                                               (near.empty() ? "" : "did you mean " + near + "? ") +
                                               "there are:" + known);
}

ExitCode run(const Options& options) {
  if (options.list || options.name.empty()) {
    if (options.json)
      std::cout << Json(names()).dump() << '\n';
    else
      for (const std::string& name : names()) std::cout << name << '\n';
    return ExitCode::done;
  }
  const std::string& text = text_of(options.name);
  if (!options.output.empty()) require_free(options.output, options.force);
  if (options.json) {
    std::cout << Json{{"name", options.name}, {"text", text}}.dump() << '\n';
  } else if (options.output.empty()) {
    std::cout << text;
  } else if (!(std::ofstream(options.output) << text)) {
    throw CommandFailed(ExitCode::not_found, "cannot write " + options.output);
  }
  return ExitCode::done;
}

}  // namespace

void add_new(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command = subcommand(app, "new", "Write a case file to begin with",
                                       "dccast new start-2d-thickness > my.toml");
  command->add_option("NAME", options->name,
                      "Name of a shipped case; without it the names are listed");
  command->add_option("-o,--output", options->output, "File to write instead of standard output");
  add_force_flag(*command, options->force);
  command->add_flag("--list", options->list, "List the names");
  command->add_flag("--json", options->json, "As JSON");
  command->callback([options, &program] { program.action = [options] { return run(*options); }; });
}

}  // namespace dccast::client::commands
