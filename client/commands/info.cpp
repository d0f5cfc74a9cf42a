#include <iostream>

#include "client/commands/commands.hpp"
#include "client/message_json.hpp"
#include "client/render/table.hpp"

namespace dccast::client::commands {
namespace {

struct Options {
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

ExitCode run(const Options& options, Program& program) {
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
  if (!info.storage_fault().empty())
    std::cout << "held     " << info.storage_fault() << "; no job starts until this is fixed\n";
  if (info.quarantined() > 0)
    std::cout << "aside    " << info.quarantined()
              << " folders without a job; `dccastd check` lists them\n";
  return ExitCode::done;
}

}  // namespace

void add_info(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command =
      subcommand(app, "info", "What the server is and how busy it is", "dccast info --json");
  command->add_flag("--json", options->json, "As JSON");
  command->callback([options, &program] {
    program.action = [options, &program] { return run(*options, program); };
  });
}

}  // namespace dccast::client::commands
