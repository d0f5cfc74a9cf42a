#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "client/cli/options.hpp"
#include "client/session/connection.hpp"
#include "client/session/ssh_tunnel.hpp"

/// The commands, several to a file by what they are about. Each `add_` function declares one: its
/// options and its action.
namespace dccast::client::commands {

/// What the command line has for every command.
struct Program {
  std::string server;                     ///< name or address of the daemon; empty: the default
  std::filesystem::path configuration{};  ///< the user's settings; empty: none
  std::filesystem::path servers{};        ///< logins of the user; empty: none
  std::shared_ptr<Interruption> interruption = std::make_shared<Interruption>();
  mutable std::shared_ptr<SshTunnel> tunnel{};  ///< of a server that is meant by ssh://
  /// To the server that is meant: one of a login, else one on loopback. Throws CommandFailed.
  Endpoint endpoint() const;
  Connection connect() const { return Connection(endpoint(), interruption); }
};

void add_new(cli::CommandLine& line, Program& program);
void add_validate(cli::CommandLine& line, Program& program);
void add_submit(cli::CommandLine& line, Program& program);
void add_watch(cli::CommandLine& line, Program& program);
void add_wait(cli::CommandLine& line, Program& program);
void add_query(cli::CommandLine& line, Program& program);
void add_compare(cli::CommandLine& line, Program& program);
void add_completion(cli::CommandLine& line, Program& program);
void add_list(cli::CommandLine& line, Program& program);
void add_show(cli::CommandLine& line, Program& program);
void add_curl(cli::CommandLine& line, Program& program);
void add_dashboard(cli::CommandLine& line, Program& program);
void add_contraction(cli::CommandLine& line, Program& program);
void add_cancel(cli::CommandLine& line, Program& program);
void add_pause(cli::CommandLine& line, Program& program);
void add_resume(cli::CommandLine& line, Program& program);
void add_delete(cli::CommandLine& line, Program& program);
void add_label(cli::CommandLine& line, Program& program);
void add_pin(cli::CommandLine& line, Program& program);
void add_unpin(cli::CommandLine& line, Program& program);
void add_top(cli::CommandLine& line, Program& program);
void add_usage(cli::CommandLine& line, Program& program);
void add_case(cli::CommandLine& line, Program& program);
void add_logs(cli::CommandLine& line, Program& program);
void add_fetch(cli::CommandLine& line, Program& program);
void add_convergence(cli::CommandLine& line, Program& program);
void add_sweep(cli::CommandLine& line, Program& program);
void add_predict(cli::CommandLine& line, Program& program);
void add_uncertainty(cli::CommandLine& line, Program& program);
void add_sensitivity(cli::CommandLine& line, Program& program);
void add_calibrate(cli::CommandLine& line, Program& program);
void add_design_mould(cli::CommandLine& line, Program& program);
void add_design_recipe(cli::CommandLine& line, Program& program);
void add_studies(cli::CommandLine& line, Program& program);
void add_report(cli::CommandLine& line, Program& program);
void add_schema(cli::CommandLine& line, Program& program);
void add_alloys(cli::CommandLine& line, Program& program);
void add_login(cli::CommandLine& line, Program& program);
void add_logout(cli::CommandLine& line, Program& program);
void add_whoami(cli::CommandLine& line, Program& program);
void add_doctor(cli::CommandLine& line, Program& program);
void add_info(cli::CommandLine& line, Program& program);

/// Follows a job as `watch` does and reports how it ended; results on stdout unless
/// `messages_only`.
/// @param strict  findings beyond notes give ExitCode::solve_failed
ExitCode watch_job(Connection& connection, const std::string& id, std::int64_t from, bool json,
                   bool messages_only, bool strict = false);

/// Waits until jobs have ended and prints how, in the order given.
/// @param command  run in a shell for each of them; empty: none
ExitCode wait_for_jobs(Connection& connection, const std::vector<std::string>& ids,
                       const std::string& command, bool json);

}  // namespace dccast::client::commands

namespace dccast::client {

/// Parses the arguments (without the program's name) and runs the subcommand. Never throws.
/// @return exit code of the process
int run_command_line(const std::vector<std::string>& arguments, commands::Program& program);

}  // namespace dccast::client
