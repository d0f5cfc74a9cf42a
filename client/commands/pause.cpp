#include <iostream>

#include "client/commands/commands.hpp"
#include "client/message_json.hpp"
#include "client/render/job_text.hpp"

namespace dccast::client::commands {
namespace {

struct Options {
  std::string id;
  bool json = false;
};

ExitCode run(const Options& options, Program& program) {
  Connection connection = program.connect();
  v1::PauseJobRequest request;
  request.set_id(options.id);
  const v1::Job job = connection.call(&Stub::PauseJob, request);
  if (options.json)
    std::cout << to_json(job).dump() << '\n';
  else
    std::cout << job.id() << " " << render::state_text(job.state()) << '\n';
  return ExitCode::done;
}

}  // namespace

void add_pause(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command = subcommand(
      app, "pause", "Stop a job at a checkpoint and keep it out of the queue", "dccast pause JOB");
  command->add_option("JOB", options->id, "Job id")->required();
  command->add_flag("--json", options->json, "As JSON");
  command->callback([options, &program] {
    program.action = [options, &program] { return run(*options, program); };
  });
}

}  // namespace dccast::client::commands
