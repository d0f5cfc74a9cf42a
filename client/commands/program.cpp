#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <utility>

#include "client/commands/commands.hpp"
#include "client/html/pages.hpp"
#include "client/model/judgement_json.hpp"
#include "client/session/servers.hpp"
#include "client/text/judgement_text.hpp"
#include "client/text/table.hpp"
#include "proto/values/local_socket.hpp"

namespace dccast::client {
namespace {

struct InfoOptions {
  bool json = false;
};

/// Limits of the daemon; empty if the daemon does not report them.
std::string ceilings_text(const v1::GetServerInfoResponse& info) {
  constexpr double bytes_of_a_megabyte = 1e6;
  if (info.maximum_nodes() <= 0) return {};
  return "ceilings " + std::to_string(info.maximum_nodes()) + " nodes, " +
         std::to_string(info.maximum_steps()) + " steps, " +
         fixed(info.maximum_memory_bytes() / bytes_of_a_megabyte, 0) +
         " MB of memory for one case\n";
}

ExitCode run(const InfoOptions& options, Program& program) {
  Connection connection = program.connect();
  const auto info = connection.call(&Stub::GetServerInfo, v1::GetServerInfoRequest());
  if (options.json) {
    print_line(to_json(info));
    return ExitCode::done;
  }

  std::cout << "server   " << connection.server() << "\nversion  " << info.version()
            << "\nworkers  " << info.workers() << "\nrunning  " << info.running() << "\nqueued   "
            << info.queued() << " of at most " << info.maximum_queued() << "\npaused   "
            << info.paused() << "\nlargest  " << info.maximum_message_bytes()
            << " bytes of a request\n"
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
    R"(dccast completion bash > ~/.local/share/bash-completion/completions/dccast
  dccast completion zsh > "${fpath[1]}/_dccast"
  dccast completion fish > ~/.config/fish/completions/dccast.fish)";

struct Group {
  const char* heading;
  std::vector<Add*> commands;
};

/// Commands in the order of the help text.
const std::vector<Group>& groups() {
  static const std::vector<Group> all{
      {"Commands to prepare a case", {add_new, add_validate, add_schema, add_alloys}},
      {"Commands to ask at once", {add_query, add_compare}},
      {"Commands to run jobs",
       {add_submit, add_follow, add_forecast, add_line, add_replay, add_watch, add_wait, add_list,
        add_show, add_top, add_cancel, add_pause, add_resume, add_priority, add_label, add_pin,
        add_unpin, add_delete}},
      {"Commands to read results",
       {add_curl, add_report, add_dashboard, add_probe, add_contraction, add_fetch, add_case,
        add_logs}},
      {"Commands to study a case",
       {add_convergence, add_uncertainty, add_sensitivity, add_calibrate, add_remedy, add_sweep,
        add_predict, add_design_recipe, add_design_mould, add_studies}},
      {"Commands to reach a server",
       {add_login, add_logout, add_whoami, add_web_line, add_tokens, add_doctor, add_info,
        add_usage, add_completion}}};
  return all;
}

const char* const guide =
    "\nA question:\n"
    "  dccast query my.toml --set schedule.hold=\"90 s\"\n"
    "\nA first run:\n"
    "  dccast new start-2d-thickness > my.toml   a case to begin with\n"
    "  dccast validate my.toml                   everything that is wrong with it, at once\n"
    "  dccast submit --watch my.toml             run it and follow the butt curl\n"
    "  dccast fetch JOB -o results.h5            HDF5, and XDMF for ParaView\n"
    "  dccast report JOB -o report.html          one page that opens from disk\n"
    "\nExit codes: 0 done, 2 usage or invalid case, 3 the solve failed, 4 server unreachable or\n"
    "refused, 5 not found or not allowed, 6 not in its present state, 7 output could not be\n"
    "written, 130 interrupted (Ctrl-C, SIGTERM; a job goes on). Results go to standard output, "
    "messages to standard error. JOB is\n"
    "an id, the beginning of one, or `last`. Defaults are in ~/.config/dccast/client.toml. `dccast "
    "COMMAND\n"
    "--help` shows the options of a command with an example.";

/// Reason why standard output cannot be written. errno is already overwritten, so the write is
/// tried again.
std::string reason_against_output() {
  std::clearerr(stdout);
  if (std::fputc('\n', stdout) != EOF && std::fflush(stdout) == 0) return {};
  return std::string(": ") + std::strerror(errno);
}

}  // namespace

Endpoint Program::endpoint() const {
  if (SshTunnel::is_meant(server)) {
    if (!tunnel) {
      tunnel = std::make_shared<SshTunnel>(server);
      tunnel->open();
    }
    return {.address = tunnel->address()};
  }
  const StoredServers stored(servers);
  if (const StoredServer* named = stored.find(server)) {
    if (named->ends_soon() && !std::exchange(warned, true))
      std::cerr << "dccast: your token for " << named->name << " ends on "
                << utc_text(std::atoll(named->expires.c_str()))
                << "; renew it: dccast login --renew\n";
    return named->endpoint;
  }
  return endpoint_of(server.empty() ? values::local_server() : server);
}

void add_info(CommandLine& line, Program& program) {
  const auto [command, options] = declare<InfoOptions>(
      line, program, run, "info", "What the server is and how busy it is", "dccast info --json");
  command.json(options.json);
}

void add_completion(CommandLine& line, Program&) {
  const auto shell = std::make_shared<std::string>();
  const Command command =
      line.command("completion", "Print a script for shell completion", completion_examples);
  command.option("SHELL", *shell, "bash, zsh or fish",
                 {.required = true, .one_of = {"bash", "zsh", "fish"}});
  command.action([shell, &line] {
    std::cout << completion_script(line.commands(), *shell);
    return ExitCode::done;
  });
}

void print_line(const Json& json) {
  std::cout << json.dump() << '\n';
}

void print_answer(const StudyOptions& options, const v1::StudyJudgement& answer,
                  const std::string& other_output) {
  if (!options.plot.empty()) write_output(options.plot, judgement_page(answer));

  if (options.json)
    print_line(study_json(answer));
  else if (options.plot != "-" && other_output != "-")
    std::cout << study_judgement_text(answer, terminal_of(STDOUT_FILENO));
  std::cout << std::flush;
}

int run_command_line(const std::vector<std::string>& arguments, Program& program) {
  CommandLine line("dccast", "Simulate the start of direct-chill casting on a dccastd server",
                   DCCAST_VERSION, guide);
  for (const Group& group : groups()) {
    line.begin_group(group.heading);
    for (Add* const add : group.commands) add(line, program);
  }

  // A command whose output could not be written fails.
  std::cout.exceptions(std::ios::badbit);
  try {
    apply_configuration(program.configuration, line, program.server);
    line.global_option("--server", program.server,
                       "Name of a login, address of dccastd on this machine, or ssh://[USER@]HOST; "
                       "also after a command",
                       "DCCAST_SERVER");
    const ExitCode code = line.run(arguments);
    std::cout.flush();
    return static_cast<int>(code);
  } catch (const std::ios_base::failure& failure) {
    if (!std::cout.bad()) {
      std::cerr << "dccast: a file cannot be read: " << failure.what() << '\n';
      return static_cast<int>(ExitCode::invalid);
    }
    const std::string reason = reason_against_output();
    std::cout.exceptions(std::ios::goodbit);  // what std::cerr is given flushes it once more
    std::cerr << "dccast: standard output cannot be written" << reason << '\n';
    return static_cast<int>(ExitCode::output_lost);
  } catch (const CommandFailed& failure) {
    std::cerr << "dccast: " << failure.what() << '\n';
    return static_cast<int>(failure.code());
  } catch (const std::exception& error) {
    std::cerr << "dccast: " << error.what() << '\n';
    return static_cast<int>(ExitCode::unreachable);
  }
}

}  // namespace dccast::client
