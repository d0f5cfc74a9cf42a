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
  v1::GetJobRequest request;
  request.set_id(options.id);
  const v1::Job job = connection.call(&Stub::GetJob, request);
  if (options.json)
    std::cout << to_json(job).dump() << '\n';
  else
    std::cout << render::job_sheet(job);
  return ExitCode::done;
}

}  // namespace

void add_show(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command = subcommand(app, "show", "Everything about one job", "dccast show JOB");
  command->add_option("JOB", options->id, "Job id")->required();
  command->add_flag("--json", options->json, "As JSON");
  command->callback([options, &program] {
    program.action = [options, &program] { return run(*options, program); };
  });
}

}  // namespace dccast::client::commands
