#include <iostream>

#include "client/commands/commands.hpp"
#include "client/message_json.hpp"

namespace dccast::client::commands {
namespace {

struct Options {
  bool json = false;
};

ExitCode run(const Options& options, Program& program) {
  Connection connection = program.connect();
  const auto info = connection.call(&Stub::GetServerInfo, v1::GetServerInfoRequest());
  if (options.json) {
    std::cout << to_json(info).dump() << '\n';
    return ExitCode::done;
  }
  std::cout << "server   " << connection.server() << "\nversion  " << info.version()
            << "\nworkers  " << info.workers() << "\nrunning  " << info.running() << "\nqueued   "
            << info.queued() << " of at most " << info.maximum_queued() << "\nlargest  "
            << info.maximum_message_bytes() << " bytes of case and attachments\nbuild    "
            << info.build() << '\n';
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
