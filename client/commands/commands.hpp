#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/common_options.hpp"
#include "client/cli/options.hpp"
#include "client/model/json.hpp"
#include "client/session/connection.hpp"
#include "client/session/jobs.hpp"
#include "client/session/ssh_tunnel.hpp"

/// The commands, several to a file by what they are about.
namespace dccast::client {

/// What the command line has for every command.
struct Program {
  std::string server;                     ///< name or address of the daemon; empty: the default
  std::filesystem::path configuration{};  ///< the user's settings; empty: none
  std::filesystem::path servers{};        ///< logins of the user; empty: none
  std::shared_ptr<Interruption> interruption = std::make_shared<Interruption>();
  mutable std::shared_ptr<SshTunnel> tunnel{};  ///< of a server that is meant by ssh://
  mutable bool warned = false;                  ///< of a token that ends soon
  /// To the server that is meant: one of a login, else of this machine. Throws CommandFailed.
  Endpoint endpoint() const;
  /// Connects to the server that options, environment, settings and logins choose. Throws
  /// CommandFailed.
  Connection connect() const { return Connection(endpoint(), interruption); }
};

/// Adds a command to the line. @return it and its options, which are to be declared; they have
/// their values when `run` is called.
template <typename Options>
std::pair<Command, Options&> declare(CommandLine& line, Program& program,
                                     ExitCode (*run)(const Options&, Program&),
                                     const std::string& name, const std::string& description,
                                     const std::string& example) {
  const auto options = std::make_shared<Options>();
  const Command command = line.command(name, description, example);
  command.action([=, &program] { return run(*options, program); });
  return {command, *options};
}

/// Computes a case file at draft, as `query` does, and prints its curl and findings.
ExitCode check_by_draft(const std::string& file, Program& program);

/// Declares one command: its options and its action.
using Add = void(CommandLine&, Program&);
/// Each adds one command with its options: cases; runs; jobs and what is known of them; results;
/// studies; servers and this program.
Add add_new, add_validate, add_schema, add_alloys;
Add add_submit, add_follow, add_forecast, add_line, add_replay, add_watch, add_query, add_compare;
Add add_list, add_show, add_wait, add_cancel, add_pause, add_resume, add_delete;
Add add_label, add_priority, add_pin, add_unpin, add_usage, add_case, add_logs, add_top;
Add add_curl, add_probe, add_contraction, add_fetch, add_report, add_dashboard;
Add add_studies, add_convergence, add_sweep, add_predict, add_uncertainty, add_sensitivity;
Add add_remedy;
Add add_calibrate, add_design_mould, add_design_recipe;
Add add_login, add_logout, add_whoami, add_web_line, add_tokens, add_doctor, add_info,
    add_completion;

/// The names of priorities on the command line.
const std::map<std::string, int>& priorities();

/// Writes JSON to standard output, on one line.
void print_line(const Json& json);

/// Writes the answer of a study as its command was asked to: as a page, as JSON or as text.
/// @param other_output  of the command, "-" where standard output is taken by it
void print_answer(const StudyOptions& options, const v1::StudyJudgement& answer,
                  const std::string& other_output = {});

/// Prints what the server concludes from a run that has a step. One that it cannot judge gets a
/// line on standard error. @param line  also what its castings say of the recipe; empty: none
void print_judgement(Connection& connection, const v1::ComparedRun& run, std::ostream& stream,
                     const std::string& line = {});

/// Follows a job as `watch` does and reports how it ended; results on stdout unless
/// `messages_only`.
/// @param strict  findings beyond notes give ExitCode::solve_failed
ExitCode watch_job(Connection& connection, const std::string& id, std::int64_t from, bool json,
                   bool messages_only, bool strict, const RetryPolicy& policy = {});

/// Waits until jobs have ended and prints how, in the order given.
/// @param command  run in a shell for each of them; empty: none
ExitCode wait_for_jobs(Connection& connection, const std::vector<std::string>& ids,
                       const std::string& command, bool json);

}  // namespace dccast::client

namespace dccast::client {

/// Parses the arguments (without the program's name) and runs the subcommand. Never throws.
/// @return exit code of the process
int run_command_line(const std::vector<std::string>& arguments, Program& program);

}  // namespace dccast::client
