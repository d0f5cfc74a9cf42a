#include <iostream>

#include "client/commands/commands.hpp"
#include "client/message_json.hpp"
#include "client/render/terminal.hpp"
#include "dccast/v1/config.pb.h"
#include "proto/case_file/case_file.hpp"

namespace dccast::client::commands {
namespace {

struct Options {
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
          {"doc", row.doc}};
}

ExitCode run(const Options& options) {
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

}  // namespace

void add_schema(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command = subcommand(
      app, "schema", "Reference of every key of a case file: unit, range, default, meaning",
      "dccast schema cooling.water");
  command->add_option("PART", options->prefix, "Only keys with this in their path");
  command->add_flag("--daemon", options->daemon, "Keys of the daemon's configuration instead");
  command->add_flag("--json", options->json, "As JSON");
  command->callback([options, &program] { program.action = [options] { return run(*options); }; });
}

}  // namespace dccast::client::commands
