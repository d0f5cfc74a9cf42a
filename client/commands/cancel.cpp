#include <iostream>

#include "client/commands/commands.hpp"
#include "client/message_json.hpp"
#include "client/render/job_text.hpp"

namespace dccast::client::commands {
namespace {

struct Options {
  std::string id;
  std::string reason;
  bool json = false;
};

ExitCode run(const Options& options, Program& program) {
  Connection connection = program.connect();
  v1::CancelJobRequest request;
  request.set_id(options.id);
  request.set_reason(options.reason);
  const v1::Job job = connection.call(&Stub::CancelJob, request);
  if (options.json)
    std::cout << to_json(job).dump() << '\n';
  else
    std::cout << job.id() << " " << render::state_text(job.state()) << '\n';
  return ExitCode::done;
}

}  // namespace

void add_cancel(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command =
      subcommand(app, "cancel", "Stop a job for good; one that has ended is left as it is",
                 "dccast cancel JOB --reason \"wrong alloy\"");
  command->add_option("JOB", options->id, "Job id")->required();
  command->add_option("--reason", options->reason, "Kept with the job");
  command->add_flag("--json", options->json, "As JSON");
  command->callback([options, &program] {
    program.action = [options, &program] { return run(*options, program); };
  });
}

}  // namespace dccast::client::commands
