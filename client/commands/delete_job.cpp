#include <iostream>

#include "client/commands/commands.hpp"
#include "client/message_json.hpp"

namespace dccast::client::commands {
namespace {

struct Options {
  std::string id;
  bool json = false;
};

ExitCode run(const Options& options, Program& program) {
  Connection connection = program.connect();
  v1::DeleteJobRequest request;
  request.set_id(options.id);
  connection.call_once(&Stub::DeleteJob, request);
  if (options.json)
    std::cout << Json{{"id", options.id}, {"deleted", true}}.dump() << '\n';
  else
    std::cerr << "deleted " << options.id << '\n';
  return ExitCode::done;
}

}  // namespace

void add_delete(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command =
      subcommand(app, "delete", "Remove an ended job and its files", "dccast delete JOB");
  command->add_option("JOB", options->id, "Job id")->required();
  command->add_flag("--json", options->json, "As JSON");
  command->callback([options, &program] {
    program.action = [options, &program] { return run(*options, program); };
  });
}

}  // namespace dccast::client::commands
