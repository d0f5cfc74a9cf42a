#include "client/configuration.hpp"

#include <cstdlib>
#include <sstream>

#include <toml++/toml.h>

#include "client/failure.hpp"
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
    throw CommandFailed(ExitCode::invalid, file_.string() + ":" + std::to_string(at.line) + ":" +
                                               std::to_string(at.column) + ": " + what);
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

std::vector<std::string> option_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* const option : command.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back(name);
  return names;
}

void set_default(const toml::key& key, const toml::node& node, CLI::App& command,
                 const Settings& settings) {
  const std::string name(key.str());
  CLI::Option* const option = command.get_option_no_throw("--" + name);
  if (option == nullptr || name == "help")
    settings.refuse_unknown(key, option_names(command), "option of " + command.get_name());
  try {
    option->run_callback_for_default()->default_val(text_of(node));
  } catch (const CLI::Error& error) {
    settings.refuse(node.source().begin, error.what());
  }
}

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names{"server"};
  for (const CLI::App* const command : app.get_subcommands({}))
    names.push_back(command->get_name());
  return names;
}

/// Null where there is no such command.
CLI::App* command_named(CLI::App& app, std::string_view name) {
  const auto found =
      app.get_subcommands([&](CLI::App* command) { return command->get_name() == name; });
  return found.empty() ? nullptr : found.front();
}

void set_defaults(const toml::key& key, const toml::node& node, CLI::App& app,
                  const Settings& settings) {
  CLI::App* const command = command_named(app, key.str());
  if (command == nullptr) settings.refuse_unknown(key, command_names(app), "key");
  const toml::table* const table = node.as_table();
  if (table == nullptr)
    settings.refuse(node.source().begin,
                    "a table of defaults is expected: [" + command->get_name() + "]");
  for (const auto& [option, value] : *table) set_default(option, value, *command, settings);
}

}  // namespace

fs::path configuration_file() {
  if (const std::string file = variable("DCCAST_CONFIG"); !file.empty()) return file;
  if (const std::string folder = variable("XDG_CONFIG_HOME"); folder.starts_with('/'))
    return fs::path(folder) / "dccast" / "client.toml";
  const std::string home = variable("HOME");
  return home.empty() ? fs::path() : fs::path(home) / ".config" / "dccast" / "client.toml";
}

void apply_configuration(const fs::path& file, CLI::App& app, std::string& server) {
  std::error_code error;
  if (file.empty() || !fs::exists(file, error)) return;
  const Settings settings(file);
  for (const auto& [key, node] : parsed(file, settings)) {
    if (key.str() != "server") {
      set_defaults(key, node, app, settings);
      continue;
    }
    const auto address = node.value<std::string>();
    if (!address) settings.refuse(node.source().begin, "server is text, e.g. \"127.0.0.1:7117\"");
    server = *address;
  }
}

}  // namespace dccast::client
