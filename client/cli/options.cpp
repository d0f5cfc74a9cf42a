#include "client/cli/options.hpp"

#include <algorithm>
#include <iostream>
#include <memory>
#include <sstream>

#include <CLI/CLI.hpp>

#include "dccast/v1/case.pb.h"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/text_checks.hpp"

namespace dccast::client {
namespace {

/// "--set title=" for an option that is a key of the case, such as --title or --casting-speed;
/// empty for any other.
std::string change_for(const CLI::App& command, const std::string& option) {
  if (command.get_option_no_throw("--set") == nullptr) return {};
  std::string key = option.substr(2);
  std::ranges::replace(key, '-', '_');

  std::vector<std::string> paths;
  for (const case_file::KeyReference& known : case_file::reference(*v1::Case::descriptor())) {
    if (known.type == "table") continue;
    if (known.path == key) return "--set " + known.path + "=";
    if (known.path.ends_with("." + key)) paths.push_back(known.path);
  }
  return paths.size() == 1 ? "--set " + paths.front() + "=" : "";
}

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* const command : app.get_subcommands({}))
    names.push_back(command->get_name());
  return names;
}

/// Where the command stands, behind options of the program; the end if there is none.
std::vector<std::string>::iterator find_command(const CLI::App& app,
                                                std::vector<std::string>& arguments) {
  for (auto word = arguments.begin(); word != arguments.end(); ++word) {
    if (!word->starts_with('-')) return word;
    const CLI::Option* const option = app.get_option_no_throw(*word);
    const bool takes_value = option != nullptr && option->get_items_expected_max() > 0;
    if (takes_value && word + 1 != arguments.end()) ++word;
  }
  return arguments.end();
}

/// Suggestion for an unknown option of the given command.
std::string nearest_option(const CLI::App& app, const std::vector<std::string>& arguments) {
  const auto chosen = app.get_subcommands();
  for (const std::string& argument : arguments) {
    const std::string option = argument.substr(0, argument.find('='));
    if (chosen.empty() || !option.starts_with("--")) continue;
    if (chosen.front()->get_option_no_throw(option) != nullptr) continue;
    if (app.get_option_no_throw(option) != nullptr) continue;
    // A key of the case that was written as an option.
    if (const std::string change = change_for(*chosen.front(), option); !change.empty())
      return change + "...";

    std::vector<std::string> names;
    for (const CLI::Option* const known : chosen.front()->get_options())
      for (const std::string& name : known->get_lnames()) names.push_back("--" + name);
    return case_file::nearest(option, names);
  }
  return {};
}

CommandSummary summary_of(const CLI::App& command) {
  CommandSummary summary{command.get_name(), command.get_description(), {}, {}};
  for (const CLI::Option* const option : command.get_options()) {
    if (!option->nonpositional()) {
      summary.arguments.push_back(option->get_name(true));
      continue;
    }
    OptionSummary& added = summary.options.emplace_back(
        OptionSummary{{}, option->get_description(), option->get_items_expected_max() > 0});
    for (const std::string& name : option->get_snames()) added.names.push_back("-" + name);
    for (const std::string& name : option->get_lnames()) added.names.push_back("--" + name);
  }
  return summary;
}

void apply(const Rules& rules, CLI::Option& option) {
  option.required(rules.required);
  if (rules.show_default) option.capture_default_str();
  if (rules.comma_separated) option.delimiter(',');
  if (rules.positive) option.check(CLI::PositiveNumber);
  if (rules.count) option.expected(rules.count->low, rules.count->high);
  if (rules.between) option.check(CLI::Range(rules.between->low, rules.between->high));
  if (!rules.one_of.empty()) option.check(CLI::IsMember(rules.one_of));
  if (rules.fault) option.check(rules.fault);
  if (!rules.placeholder.empty()) option.type_name(rules.placeholder);
  if (!rules.needs.empty()) option.needs(rules.needs);
  for (const std::string& other : rules.excludes) option.excludes(other);
}

/// Lists commands by the first sentence of their description: the rest is in their own help.
class FirstSentences : public CLI::Formatter {
public:
  std::string make_subcommand(const CLI::App* command) const override {
    const std::string description = command->get_description();
    const std::size_t end = description.find(". ");
    std::stringstream line;
    CLI::detail::format_help(line, command->get_display_name(true), description.substr(0, end),
                             get_column_width());
    return line.str();
  }
};

}  // namespace

void Command::option(const std::string& names, Value value, const std::string& help,
                     const Rules& rules) const {
  std::visit([&](auto to) { apply(rules, *app_->add_option(names, to.get(), help)); }, value);
}

void Command::repeatable(const std::string& names, std::vector<std::string>& values,
                         const std::string& help, const Rules& rules) const {
  apply(rules, *app_->add_option(names, values, help)->allow_extra_args(false));
}

void Command::flag(const std::string& names, bool& value, const std::string& help,
                   const Rules& rules) const {
  apply(rules, *app_->add_flag(names, value, help));
}

void Command::choice(const std::string& names, int& value, const std::map<std::string, int>& values,
                     const std::string& help, const Rules& rules) const {
  const auto number_of = [values](std::string& text) -> std::string {
    const auto found = values.find(CLI::detail::to_lower(text));
    const bool is_number = std::ranges::any_of(
        values, [&](const auto& entry) { return text == std::to_string(entry.second); });
    if (found != values.end()) text = std::to_string(found->second);
    if (found != values.end() || is_number) return {};  // a default is a number already

    std::string permitted;
    for (const auto& [name, number] : values) permitted += (permitted.empty() ? "" : ", ") + name;
    return "'" + text + "' is none of " + permitted;
  };
  apply(rules, *app_->add_option(names, value, help)->transform(CLI::Validator(number_of, "")));
}

Command Command::command(const std::string& name, const std::string& description) const {
  CLI::App* const added = app_->add_subcommand(name, description);
  added->group("Commands");  // CLI11 would repeat the heading of the parent
  app_->require_subcommand(0, 1);
  return Command(*added, *chosen_);
}

void Command::action(Action action) const {
  app_->callback([app = app_, chosen = chosen_, action = std::move(action)] {
    if (app->get_subcommands().empty()) *chosen = action;
  });
}

CommandLine::CommandLine(const std::string& name, const std::string& description,
                         const std::string& version, const std::string& footer)
    : app_(std::make_unique<CLI::App>(description, name)) {
  app_->set_version_flag("--version", name + " " + version);
  app_->require_subcommand(1);
  app_->fallthrough();
  const auto formatter = std::make_shared<FirstSentences>();
  formatter->column_width(20);
  app_->formatter(formatter);
  app_->footer(footer);
}

CommandLine::~CommandLine() = default;

Command CommandLine::command(const std::string& name, const std::string& description,
                             const std::string& example) {
  CLI::App* const command = app_->add_subcommand(name, description);
  command->footer("\nExample:\n  " + example);
  command->formatter(std::make_shared<CLI::Formatter>());
  command->group(group_);
  return Command(*command, chosen_);
}

void CommandLine::global_option(const std::string& name, std::string& value,
                                const std::string& help, const std::string& variable) {
  app_->add_option(name, value, help)->envname(variable)->capture_default_str();
}

std::vector<CommandSummary> CommandLine::commands() const {
  std::vector<CommandSummary> commands;
  for (const CLI::App* const command : std::as_const(*app_).get_subcommands({}))
    commands.push_back(summary_of(*command));
  return commands;
}

std::string CommandLine::set_default(const std::string& command, const std::string& option,
                                     const std::string& text) {
  try {
    app_->get_subcommand(command)
        ->get_option("--" + option)
        ->run_callback_for_default()
        ->default_val(text);
    return {};
  } catch (const CLI::Error& error) {
    return error.what();
  }
}

ExitCode CommandLine::run(const std::vector<std::string>& given) {
  std::vector<std::string> arguments = given;
  auto command = find_command(*app_, arguments);

  // `dccast help submit` is `dccast submit --help`.
  if (command != arguments.end() && *command == "help") {
    arguments.erase(command);
    arguments.emplace_back("--help");
    command = find_command(*app_, arguments);
  }

  const auto names = command_names(*app_);
  if (command != arguments.end() && std::ranges::find(names, *command) == names.end()) {
    const std::string near = case_file::nearest(*command, names);
    throw invalid("there is no command '" + *command + "'" +
                  (near.empty() ? "" : "; did you mean '" + near + "'?") + "; `" +
                  app_->get_name() + " --help` lists them");
  }

  try {
    // CLI11 expects the arguments in reverse order.
    app_->parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::ParseError& error) {
    app_->exit(error, std::cout, std::cerr);
    if (error.get_exit_code() == 0) return ExitCode::done;  // help or version
    const std::string near = nearest_option(*app_, arguments);
    if (!near.empty()) std::cerr << "did you mean '" << near << "'?\n";
    return ExitCode::invalid;
  }
  return chosen_();
}

}  // namespace dccast::client
