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

/// What goes wrong with a settings file, and where.
class Settings {
public:
  explicit Settings(const fs::path& file) : file_(file) {}

  [[noreturn]] void refuse(const toml::source_position& at, const std::string& what) const {
    throw invalid(file_.string() + ":" + std::to_string(at.line) + ":" + std::to_string(at.column) +
                  ": " + what);
  }

  [[noreturn]] void refuse_unknown(const toml::key& key, const std::vector<std::string>& known,
                                   const std::string& what) const {
    const std::string near = case_file::nearest(key.str(), known);
    refuse(key.source().begin, "unknown " + what + " '" + std::string(key.str()) + "'" +
                                   (near.empty() ? "" : "; did you mean '" + near + "'?"));
  }

private:
  fs::path file_;
};

toml::table parsed(const fs::path& file, const Settings& settings) {
  try {
    return toml::parse_file(file.string());
  } catch (const toml::parse_error& error) {
    settings.refuse(error.source().begin, "not valid TOML: " + std::string(error.description()));
  }
}

/// As on the command line; of a list its words with commas between them.
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

/// Long options without their dashes.
std::vector<std::string> option_names(const cli::CommandSummary& command) {
  std::vector<std::string> names;
  for (const cli::OptionSummary& option : command.options)
    for (const std::string& name : option.names)
      if (name.starts_with("--") && name != "--help") names.push_back(name.substr(2));
  return names;
}

void set_defaults(const toml::key& key, const toml::node& node, cli::CommandLine& line,
                  const Settings& settings) {
  const auto commands = line.commands();
  std::vector<std::string> names{"server"};
  for (const cli::CommandSummary& command : commands) names.push_back(command.name);
  const auto command = std::find_if(commands.begin(), commands.end(),
                                    [&](const auto& one) { return one.name == key.str(); });
  if (command == commands.end()) settings.refuse_unknown(key, names, "key");
  const toml::table* const table = node.as_table();
  if (table == nullptr)
    settings.refuse(node.source().begin,
                    "a table of defaults is expected: [" + command->name + "]");
  const auto options = option_names(*command);
  for (const auto& [option, value] : *table) {
    if (std::find(options.begin(), options.end(), option.str()) == options.end())
      settings.refuse_unknown(option, options, "option of " + command->name);
    const std::string wrong =
        line.set_default(command->name, std::string(option.str()), text_of(value));
    if (!wrong.empty()) settings.refuse(value.source().begin, wrong);
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

void apply_configuration(const fs::path& file, cli::CommandLine& line, std::string& server) {
  std::error_code error;
  if (file.empty()) return;
  if (!fs::exists(file, error)) {
    if (file != variable("DCCAST_CONFIG")) return;
    throw invalid("DCCAST_CONFIG names " + file.string() + ", and there is no such file");
  }
  const Settings settings(file);
  for (const auto& [key, node] : parsed(file, settings)) {
    if (key.str() != "server") {
      set_defaults(key, node, line, settings);
      continue;
    }
    const auto address = node.value<std::string>();
    if (!address) settings.refuse(node.source().begin, "server is text, e.g. \"127.0.0.1:7117\"");
    server = *address;
  }
}

}  // namespace dccast::client
