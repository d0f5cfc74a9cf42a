#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iostream>

#include "client/cli/completion.hpp"
#include "client/cli/configuration.hpp"
#include "client/commands/commands.hpp"
#include "client/model/json.hpp"
#include "client/session/servers.hpp"
#include "client/text/table.hpp"

namespace dccast::client::commands {
namespace {

struct InfoOptions {
  bool json = false;
};

/// Limits of this daemon; empty for a daemon that does not report them.
std::string ceilings_text(const v1::GetServerInfoResponse& info) {
  constexpr double bytes_of_a_megabyte = 1e6;
  if (info.maximum_nodes() <= 0) return {};
  return "ceilings " + std::to_string(info.maximum_nodes()) + " nodes, " +
         std::to_string(info.maximum_steps()) + " steps, " +
         render::fixed(info.maximum_memory_bytes() / bytes_of_a_megabyte, 0) +
         " MB of memory for one case\n";
}

ExitCode run(const InfoOptions& options, Program& program) {
  Connection connection = program.connect();
  const auto info = connection.call(&Stub::GetServerInfo, v1::GetServerInfoRequest());
  if (options.json) {
    std::cout << to_json(info).dump() << '\n';
    return ExitCode::done;
  }
  std::cout << "server   " << connection.server() << "\nversion  " << info.version()
            << "\nworkers  " << info.workers() << "\nrunning  " << info.running() << "\nqueued   "
            << info.queued() << " of at most " << info.maximum_queued() << "\npaused   "
            << info.paused() << "\nlargest  " << info.maximum_message_bytes()
            << " bytes of case and attachments\n"
            << ceilings_text(info) << "build    " << info.build() << '\n';
  if (!info.worker_sandbox().empty()) std::cout << "sandbox  " << info.worker_sandbox() << '\n';
  if (!info.storage_fault().empty())
    std::cout << "held     " << info.storage_fault() << "; no job starts until this is fixed\n";
  if (info.quarantined() > 0)
    std::cout << "aside    " << info.quarantined()
              << " folders without a job; `dccastd check` lists them\n";
  return ExitCode::done;
}

constexpr const char* completion_examples =
    "dccast completion bash > ~/.local/share/bash-completion/completions/dccast\n"
    "  dccast completion zsh > \"${fpath[1]}/_dccast\"\n"
    "  dccast completion fish > ~/.config/fish/completions/dccast.fish";

}  // namespace

Endpoint Program::endpoint() const {
  if (SshTunnel::is_meant(server)) {
    if (!tunnel) tunnel = std::make_shared<SshTunnel>(server);
    return {.address = tunnel->address()};
  }
  const StoredServers stored(servers);
  if (const StoredServer* named = stored.find(server)) return named->endpoint;
  return endpoint_of(server.empty() ? "127.0.0.1" : server);
}

void add_info(cli::CommandLine& line, Program& program) {
  const auto options = std::make_shared<InfoOptions>();
  const cli::Command command =
      line.command("info", "What the server is and how busy it is", "dccast info --json");
  command.json(options->json);
  command.action([options, &program] { return run(*options, program); });
}

void add_completion(cli::CommandLine& line, Program&) {
  const auto shell = std::make_shared<std::string>();
  const cli::Command command = line.command(
      "completion", "Print a script for shell completion of dccast", completion_examples);
  command.option("SHELL", *shell, "bash, zsh or fish").required().one_of({"bash", "zsh", "fish"});
  command.action([shell, &line] {
    std::cout << completion_script(line.commands(), *shell);
    return ExitCode::done;
  });
}

}  // namespace dccast::client::commands

namespace dccast::client {
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

void add_commands(cli::CommandLine& line, commands::Program& program) {
  for (const auto add :
       {commands::add_new,           commands::add_validate,    commands::add_query,
        commands::add_submit,        commands::add_watch,       commands::add_wait,
        commands::add_list,          commands::add_show,        commands::add_curl,
        commands::add_dashboard,     commands::add_contraction, commands::add_compare,
        commands::add_fetch,         commands::add_report,      commands::add_convergence,
        commands::add_sweep,         commands::add_predict,     commands::add_uncertainty,
        commands::add_sensitivity,   commands::add_calibrate,   commands::add_design_mould,
        commands::add_design_recipe, commands::add_studies,     commands::add_cancel,
        commands::add_pause,         commands::add_resume,      commands::add_delete,
        commands::add_schema,        commands::add_login,       commands::add_logout,
        commands::add_whoami,        commands::add_doctor,      commands::add_alloys,
        commands::add_info,          commands::add_completion,  commands::add_usage,
        commands::add_case,          commands::add_logs,        commands::add_label,
        commands::add_pin,           commands::add_unpin,       commands::add_top})
    add(line, program);
}

/// Why standard output cannot be written: errno has been overwritten by then, so it is tried again.
std::string reason_against_output() {
  std::clearerr(stdout);
  if (std::fputc('\n', stdout) != EOF && std::fflush(stdout) == 0) return {};
  return std::string(": ") + std::strerror(errno);
}

}  // namespace

int run_command_line(const std::vector<std::string>& arguments, commands::Program& program) {
  cli::CommandLine line("dccast", "Simulate the start of direct-chill casting on a dccastd server",
                        DCCAST_VERSION, guide);
  add_commands(line, program);
  // Output that could not be written is no success, whichever command wrote it.
  std::cout.exceptions(std::ios::badbit);
  try {
    apply_configuration(program.configuration, line, program.server);
    line.global_option(
        "--server", program.server,
        "Name of a login, address of dccastd on this machine, or ssh://[USER@]HOST; also after a "
        "command",
        "DCCAST_SERVER");
    const ExitCode code = line.run(arguments);
    std::cout.flush();
    return static_cast<int>(code);
  } catch (const std::ios_base::failure&) {
    const std::string reason = reason_against_output();
    std::cout.exceptions(std::ios::goodbit);  // what std::cerr is given flushes it once more
    std::cerr << "dccast: standard output cannot be written" << reason << '\n';
    return static_cast<int>(ExitCode::not_found);
  } catch (const CommandFailed& failure) {
    std::cerr << "dccast: " << failure.what() << '\n';
    return static_cast<int>(failure.code());
  } catch (const std::exception& error) {
    std::cerr << "dccast: " << error.what() << '\n';
    return static_cast<int>(ExitCode::unreachable);
  }
}

}  // namespace dccast::client
