#include "client/command_line.hpp"

#include <iostream>

#include "client/configuration.hpp"
#include "proto/case_file/text_checks.hpp"

namespace dccast::client {
namespace commands {

CLI::App* subcommand(CLI::App& app, const std::string& name, const std::string& description,
                     const std::string& example) {
  CLI::App* const command = app.add_subcommand(name, description);
  command->footer("\nExample:\n  " + example);
  return command;
}

}  // namespace commands

namespace {

const char* const guide =
    "\nA question:\n"
    "  dccast query my.toml --set schedule.casting_speed=\"70 mm/min\"\n"
    "\nA first run:\n"
    "  dccast new start-2d-thickness > my.toml   a case to begin with\n"
    "  dccast validate my.toml                   everything that is wrong with it, at once\n"
    "  dccast submit --watch my.toml             run it and follow the butt curl\n"
    "  dccast fetch JOB -o results.h5            HDF5, and XDMF for ParaView\n"
    "  dccast report JOB -o report.html          one page that opens from disk\n"
    "\nExit codes: 0 done, 2 usage or invalid case, 3 the solve failed, 4 server unreachable or\n"
    "refused, 5 not found or not allowed, 6 not in its present state, 130 interrupted (Ctrl-C,\n"
    "SIGTERM; a job goes on). Results go to standard output, messages to standard error. JOB is\n"
    "an id, the beginning of one, or `last`. Defaults are in ~/.config/dccast/client.toml. `dccast "
    "COMMAND\n"
    "--help` shows the options of a command with an example.";

void add_subcommands(CLI::App& app, commands::Program& program) {
  for (const auto add :
       {commands::add_new,         commands::add_validate,     commands::add_query,
        commands::add_submit,      commands::add_watch,        commands::add_wait,
        commands::add_list,        commands::add_show,         commands::add_curl,
        commands::add_contraction, commands::add_compare,      commands::add_fetch,
        commands::add_report,      commands::add_convergence,  commands::add_sweep,
        commands::add_predict,     commands::add_design_mould, commands::add_studies,
        commands::add_cancel,      commands::add_pause,        commands::add_resume,
        commands::add_delete,      commands::add_schema,       commands::add_alloys,
        commands::add_info,        commands::add_completion})
    add(app, program);
}

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* const command : app.get_subcommands({}))
    names.push_back(command->get_name());
  return names;
}

std::vector<std::string> option_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* const option : command.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

/// Suggestion for an unknown command, or for an unknown option of the given command.
std::string nearest_word(const CLI::App& app, const std::vector<std::string>& arguments) {
  const auto chosen = app.get_subcommands();
  for (const std::string& word : arguments) {
    if (chosen.empty() && !word.starts_with('-'))
      return case_file::nearest(word, command_names(app));
    const std::string option = word.substr(0, word.find('='));
    if (chosen.empty() || !option.starts_with("--")) continue;
    if (chosen.front()->get_option_no_throw(option) != nullptr) continue;
    if (app.get_option_no_throw(option) == nullptr)
      return case_file::nearest(option, option_names(*chosen.front()));
  }
  return {};
}

ExitCode report_usage(const CLI::App& app, const CLI::ParseError& error,
                      const std::vector<std::string>& arguments) {
  const bool asked_for_help = error.get_exit_code() == 0;
  app.exit(error, std::cout, std::cerr);
  if (asked_for_help) return ExitCode::done;
  if (const std::string near = nearest_word(app, arguments); !near.empty())
    std::cerr << "did you mean '" << near << "'?\n";
  return ExitCode::invalid;
}

}  // namespace

int run_command_line(std::vector<std::string> arguments, commands::Program& program) {
  CLI::App app{"Simulate the start of direct-chill casting on a dccastd server", "dccast"};
  app.set_version_flag("--version", std::string("dccast ") + DCCAST_VERSION);
  if (program.server.empty()) program.server = "127.0.0.1:7117";
  app.require_subcommand(1);
  app.fallthrough();
  app.footer(guide);
  add_subcommands(app, program);
  try {
    apply_configuration(program.configuration, app, program.server);
    app.add_option("--server", program.server, "Address of dccastd; also before or after a command")
        ->envname("DCCAST_SERVER")
        ->capture_default_str();
    // CLI11 expects the arguments in reverse order.
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
    return static_cast<int>(program.action());
  } catch (const CLI::ParseError& error) {
    return static_cast<int>(report_usage(app, error, arguments));
  } catch (const CommandFailed& failure) {
    std::cerr << "dccast: " << failure.what() << '\n';
    return static_cast<int>(failure.code());
  } catch (const std::exception& error) {
    std::cerr << "dccast: " << error.what() << '\n';
    return static_cast<int>(ExitCode::unreachable);
  }
}

}  // namespace dccast::client
