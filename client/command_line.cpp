#include "client/command_line.hpp"

#include <algorithm>
#include <iostream>

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
    "\nA first run:\n"
    "  dccast new start-2d-thickness > my.toml   a case to begin with\n"
    "  dccast validate my.toml                   everything that is wrong with it, at once\n"
    "  dccast submit --watch my.toml             run it and follow the butt curl\n"
    "  dccast fetch JOB -o results.h5            HDF5, and XDMF for ParaView\n"
    "  dccast report JOB -o report.html          one page that opens from disk\n"
    "\nExit codes: 0 done, 2 usage or invalid case, 3 the solve failed, 4 server unreachable or\n"
    "refused, 5 not found or not allowed, 130 interrupted (Ctrl-C, SIGTERM; a job goes on). Results\n"
    "go to standard output, talk to standard error. `dccast COMMAND --help` shows the options of a\n"
    "command with an example.";

void add_subcommands(CLI::App& app, commands::Program& program) {
  for (const auto add :
       {commands::add_new, commands::add_validate, commands::add_submit, commands::add_watch,
        commands::add_list, commands::add_show, commands::add_curl, commands::add_fetch,
        commands::add_report, commands::add_convergence, commands::add_sweep,
        commands::add_predict, commands::add_studies, commands::add_cancel, commands::add_pause, commands::add_resume,
        commands::add_delete, commands::add_schema, commands::add_alloys, commands::add_info})
    add(app, program);
}

}  // namespace

int run_command_line(std::vector<std::string> arguments, commands::Program& program) {
  CLI::App app{"Simulate the start of direct-chill casting on a dccastd server", "dccast"};
  app.set_version_flag("--version", std::string("dccast ") + DCCAST_VERSION);
  if (program.server.empty()) program.server = "127.0.0.1:7117";
  app.add_option("--server", program.server, "Address of dccastd; also before or after a command")
      ->envname("DCCAST_SERVER")
      ->capture_default_str();
  app.require_subcommand(1);
  app.fallthrough();
  app.footer(guide);
  add_subcommands(app, program);
  try {
    std::reverse(arguments.begin(), arguments.end());  // CLI11 takes them from the back
    app.parse(arguments);
    return static_cast<int>(program.action());
  } catch (const CLI::ParseError& error) {
    const bool asked_for_help = error.get_exit_code() == 0;
    app.exit(error, std::cout, std::cerr);
    return static_cast<int>(asked_for_help ? ExitCode::done : ExitCode::invalid);
  } catch (const CommandFailed& failure) {
    std::cerr << "dccast: " << failure.what() << '\n';
    return static_cast<int>(failure.code());
  } catch (const std::exception& error) {
    std::cerr << "dccast: " << error.what() << '\n';
    return static_cast<int>(ExitCode::unreachable);
  }
}

}  // namespace dccast::client
