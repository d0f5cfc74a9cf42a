#include <iostream>

#include "client/commands/commands.hpp"
#include "client/job_id.hpp"
#include "client/job_watch.hpp"
#include "client/message_json.hpp"
#include "client/render/job_text.hpp"

namespace dccast::client::commands {
namespace {

struct Options {
  std::vector<std::string> ids;
  bool json = false;
};

/// Waits for one job. @return how it ended
v1::Job ended_job(Connection& connection, const std::string& id) {
  v1::GetJobRequest request;
  request.set_id(id);
  v1::Job job = connection.call(&Stub::GetJob, request);
  if (job.has_end_time()) return job;
  if (job.state() == v1::PAUSED)
    std::cerr << "waiting for job " << id << ", which is paused: dccast resume " << id << '\n';
  if (!job.held().empty()) std::cerr << "held: " << job.held() << '\n';
  follow_job(
      connection, id, 1, [](const v1::JobEvent&) {}, std::cerr);
  return connection.call(&Stub::GetJob, request);
}

ExitCode run(const Options& options, Program& program) {
  Connection connection = program.connect();
  ExitCode code = ExitCode::done;
  for (const std::string& id : resolve_jobs(connection, options.ids)) {
    const v1::Job job = ended_job(connection, id);
    std::cout << (options.json ? to_json(job).dump()
                               : job.id() + " " + render::full_state_text(job))
              << std::endl;
    if (job.state() != v1::SUCCEEDED) code = exit_code_of(job.state());
  }
  return code;
}

}  // namespace

void add_wait(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command = subcommand(
      app, "wait", "Wait until jobs have ended, say how; exit code 3 if one has not succeeded",
      "dccast wait last\n  dccast submit casts/*.toml | xargs dccast wait");
  command->add_option("JOB", options->ids, job_help)->required();
  command->add_flag("--json", options->json, "Each job as JSON on a line");
  command->callback([options, &program] {
    program.action = [options, &program] { return run(*options, program); };
  });
}

}  // namespace dccast::client::commands
