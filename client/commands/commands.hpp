#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include <CLI/CLI.hpp>

#include "client/connection.hpp"
#include "client/exit_code.hpp"

/// One subcommand per file. Each `add_` function declares its options and sets the program's
/// action.
namespace dccast::client::commands {

/// The command line as a whole.
struct Program {
  std::string server;                     ///< address of the daemon
  std::filesystem::path configuration{};  ///< the user's settings; empty: none
  std::function<ExitCode()> action;       ///< action of the chosen subcommand
  std::shared_ptr<Interruption> interruption = std::make_shared<Interruption>();
  Connection connect() const { return Connection(server, interruption); }
};

void add_new(CLI::App& app, Program& program);
void add_validate(CLI::App& app, Program& program);
void add_submit(CLI::App& app, Program& program);
void add_watch(CLI::App& app, Program& program);
void add_wait(CLI::App& app, Program& program);
void add_query(CLI::App& app, Program& program);
void add_compare(CLI::App& app, Program& program);
void add_completion(CLI::App& app, Program& program);
void add_list(CLI::App& app, Program& program);
void add_show(CLI::App& app, Program& program);
void add_curl(CLI::App& app, Program& program);
void add_contraction(CLI::App& app, Program& program);
void add_cancel(CLI::App& app, Program& program);
void add_pause(CLI::App& app, Program& program);
void add_resume(CLI::App& app, Program& program);
void add_delete(CLI::App& app, Program& program);
void add_fetch(CLI::App& app, Program& program);
void add_convergence(CLI::App& app, Program& program);
void add_sweep(CLI::App& app, Program& program);
void add_predict(CLI::App& app, Program& program);
void add_design_mould(CLI::App& app, Program& program);
void add_studies(CLI::App& app, Program& program);
void add_report(CLI::App& app, Program& program);
void add_schema(CLI::App& app, Program& program);
void add_alloys(CLI::App& app, Program& program);
void add_info(CLI::App& app, Program& program);

/// Adds a subcommand with an example below its help text.
CLI::App* subcommand(CLI::App& app, const std::string& name, const std::string& description,
                     const std::string& example);

/// Options that outlive the parsing of the command line.
template <typename Options>
std::shared_ptr<Options> make_options() {
  return std::make_shared<Options>();
}

/// Follows a job as `watch` does and reports how it ended; results on stdout unless `talk_only`.
/// @param strict  findings beyond notes give ExitCode::solve_failed
ExitCode watch_job(Connection& connection, const std::string& id, std::int64_t from, bool json,
                   bool talk_only, bool strict = false);

}  // namespace dccast::client::commands
