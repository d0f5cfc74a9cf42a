#include "client/cli/options.hpp"

#include <algorithm>
#include <cstdlib>
#include <sstream>

#include <toml++/toml.h>

#include "client/session/failure.hpp"
#include "proto/case_file/text_checks.hpp"

namespace dccast::client {
namespace {

namespace fs = std::filesystem;

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? "" : value;
}

/// A fault in a settings file, with its place.
[[noreturn]] void refuse(const fs::path& file, const toml::source_position& at,
                         const std::string& fault) {
  throw invalid(file.string() + ":" + std::to_string(at.line) + ":" + std::to_string(at.column) +
                ": " + fault);
}

[[noreturn]] void refuse_unknown(const fs::path& file, const toml::key& key,
                                 const std::vector<std::string>& known, const std::string& kind) {
  const std::string near = case_file::nearest(key.str(), known);
  refuse(file, key.source().begin,
         "unknown " + kind + " '" + std::string(key.str()) + "'" +
             (near.empty() ? "" : "; did you mean '" + near + "'?"));
}

toml::table parsed(const fs::path& file) {
  try {
    return toml::parse_file(file.string());
  } catch (const toml::parse_error& error) {
    refuse(file, error.source().begin, "not valid TOML: " + std::string(error.description()));
  }
}

/// A value as on the command line; elements of a list are joined by commas.
std::string text_of(const toml::node& node) {
  if (node.is_string()) return *node.value<std::string>();
  std::ostringstream text;
  if (const toml::array* const list = node.as_array()) {
    for (const toml::node& item : *list) text << (text.tellp() > 0 ? "," : "") << text_of(item);
  } else {
    node.visit([&](const auto& value) { text << value; });
  }
  return text.str();
}

/// Names of the long options without their dashes.
std::vector<std::string> option_names(const CommandSummary& command) {
  std::vector<std::string> names;
  for (const OptionSummary& option : command.options)
    for (const std::string& name : option.names)
      if (name.starts_with("--") && name != "--help") names.push_back(name.substr(2));
  return names;
}

void set_defaults(const toml::key& key, const toml::node& node, CommandLine& line,
                  const fs::path& file) {
  const auto commands = line.commands();
  std::vector<std::string> names{"server"};
  for (const CommandSummary& command : commands) names.push_back(command.name);
  const auto command = std::ranges::find(commands, key.str(), &CommandSummary::name);
  if (command == commands.end()) refuse_unknown(file, key, names, "key");
  const toml::table* const table = node.as_table();
  if (table == nullptr)
    refuse(file, node.source().begin, "a table of defaults is expected: [" + command->name + "]");
  // A misspelt option would change nothing, unnoticed.
  const auto options = option_names(*command);
  for (const auto& [option, value] : *table) {
    if (std::ranges::find(options, option.str()) == options.end())
      refuse_unknown(file, option, options, "option of " + command->name);
    const std::string wrong =
        line.set_default(command->name, std::string(option.str()), text_of(value));
    if (!wrong.empty()) refuse(file, value.source().begin, wrong);
  }
}

}  // namespace

fs::path configuration_file() {
  if (const std::string file = variable("DCCAST_CONFIG"); !file.empty()) return file;
  if (const std::string folder = variable("XDG_CONFIG_HOME"); folder.starts_with('/'))
    return fs::path(folder) / "dccast" / "client.toml";
  const std::string home = variable("HOME");
  return home.empty() ? fs::path() : fs::path(home) / ".config" / "dccast" / "client.toml";
}

void apply_configuration(const fs::path& file, CommandLine& line, std::string& server) {
  std::error_code error;
  if (file.empty()) return;
  if (!fs::exists(file, error)) {
    // The usual file may be missing, one that the user names may not.
    if (file != variable("DCCAST_CONFIG")) return;
    throw invalid("DCCAST_CONFIG names " + file.string() + ", and there is no such file");
  }
  for (const auto& [key, node] : parsed(file)) {
    if (key.str() != "server") {
      set_defaults(key, node, line, file);
      continue;
    }
    const auto address = node.value<std::string>();
    if (!address) refuse(file, node.source().begin, "server is text, e.g. \"casthouse:7118\"");
    server = *address;
  }
}

}  // namespace dccast::client
