#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "client/session/failure.hpp"

/// The library for command lines, wrapped once: commands declare their options here, and only
/// options.cpp includes its header.
namespace CLI {
class App;
}  // namespace CLI

namespace dccast::client {

/// Lowest and highest.
struct Range {
  int low, high;
};

/// What restricts an option or a positional argument.
struct Rules {
  bool required = false;
  bool show_default = false;     ///< in the help text
  bool comma_separated = false;  ///< "a,b" are two values
  bool positive = false;
  std::optional<Range> count{};    ///< number of values of a list
  std::optional<Range> between{};  ///< of the value
  std::vector<std::string> one_of{};
  /// What is wrong with a text; empty: nothing.
  std::function<std::string(const std::string&)> fault{};
  std::string placeholder{};  ///< of the value, in the help text
  std::string needs{};
  std::vector<std::string> excludes{};
};

inline const Rules required{.required = true};
inline const Rules shown{.show_default = true};

/// Where the value of an option goes.
using Value =
    std::variant<std::reference_wrapper<std::string>,
                 std::reference_wrapper<std::vector<std::string>>, std::reference_wrapper<int>,
                 std::reference_wrapper<std::int64_t>, std::reference_wrapper<std::uint64_t>>;

/// One command. Names are as in "-o,--output"; a name without a dash is a positional argument. The
/// values must live until the action has run.
class Command {
public:
  /// What a command does once its options have been read.
  using Action = std::function<ExitCode()>;

  /// @param chosen  is set to the action of the command that is given
  Command(CLI::App& app, Action& chosen) : app_(&app), chosen_(&chosen) {}

  /// Adds an option or, without dashes in `names`, a positional argument.
  /// @param names  as CLI11 takes them: "-o,--output"
  /// @param value  receives the value
  void option(const std::string& names, Value value, const std::string& help,
              const Rules& rules = {}) const;
  /// A list; each value has the name of the option before it.
  void repeatable(const std::string& names, std::vector<std::string>& values,
                  const std::string& help, const Rules& rules = {}) const;
  /// A number from `lowest` to `highest`; the help text shows its default.
  void number(const std::string& names, int& value, int lowest, int highest,
              const std::string& help) const {
    option(names, value, help, {.show_default = true, .between = {{lowest, highest}}});
  }
  /// Adds a flag, which takes no value.
  void flag(const std::string& names, bool& value, const std::string& help,
            const Rules& rules = {}) const;
  /// An option that takes one of the given texts, in any case.
  void choice(const std::string& names, int& value, const std::map<std::string, int>& values,
              const std::string& help, const Rules& rules = {}) const;
  /// The flag --json.
  void json(bool& value, const std::string& help = "As JSON", const Rules& rules = {}) const {
    flag("--json", value, help, rules);
  }

  /// Adds a command below this one, which then may be given or not.
  Command command(const std::string& name, const std::string& description) const;
  /// What the command does, unless one of the commands below it is given.
  void action(Action action) const;

private:
  /// The command's part of CLI11, owned by CommandLine.
  CLI::App* app_;
  Action* chosen_;
};

/// What completion and configuration need to know of an option.
struct OptionSummary {
  std::vector<std::string> names;  ///< "-w", "--watch"
  std::string help;
  /// Whether a value must follow the option.
  bool takes_value = false;
};

/// A command as completion and manual pages list it.
struct CommandSummary {
  std::string name, help;
  std::vector<OptionSummary> options;  ///< without the positional arguments
  std::vector<std::string> arguments;  ///< positional: "JOB"
};

/// The whole command line: commands, and the action of the one that was chosen.
class CommandLine {
public:
  /// @param footer  printed below the list of commands
  CommandLine(const std::string& name, const std::string& description, const std::string& version,
              const std::string& footer);
  /// CLI11's types are complete in the source only.
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;

  /// Sets the heading under which the commands that follow are listed.
  void begin_group(const std::string& heading) { group_ = heading; }
  /// Adds a command with an example below its help text. The list of all commands has the first
  /// sentence of the description.
  Command command(const std::string& name, const std::string& description,
                  const std::string& example);
  /// An option of the program that may stand before or after a command, and in the environment.
  void global_option(const std::string& name, std::string& value, const std::string& help,
                     const std::string& variable);

  /// All commands in the order of their help.
  std::vector<CommandSummary> commands() const;
  /// Sets the default of an option from a text as on the command line. @return what is wrong with
  /// the text; empty: nothing
  std::string set_default(const std::string& command, const std::string& option,
                          const std::string& text);

  /// Parses the arguments and runs the chosen action. Help goes to standard output; what is wrong
  /// with the arguments goes to standard error, with a suggestion, and gives ExitCode::invalid.
  ExitCode run(const std::vector<std::string>& given);

private:
  std::unique_ptr<CLI::App> app_;
  Command::Action chosen_;
  std::string group_ = "Commands";
};

}  // namespace dccast::client

namespace dccast::client {

/// A shell script that completes commands, options, their choices and job ids.
/// @param shell  "bash", "zsh" or "fish"
std::string completion_script(const std::vector<CommandSummary>& commands,
                              const std::string& shell);

/// Path of the user's settings: $DCCAST_CONFIG, else dccast/client.toml in $XDG_CONFIG_HOME or
/// ~/.config. Empty if none of these is defined.
std::filesystem::path configuration_file();

/// Sets the defaults of options from a TOML file: `server` at the top level, and for each command a
/// table with its name whose keys are long options, e.g. `[submit]` with `priority = "low"`. The
/// environment and the command line take precedence. A missing file is no error.
/// @param line    with all its commands, before parsing
/// @param server  set if the file names one
/// Throws CommandFailed for a file that cannot be read, an unknown key or a wrong value, with its
/// line.
void apply_configuration(const std::filesystem::path& file, CommandLine& line, std::string& server);

}  // namespace dccast::client
