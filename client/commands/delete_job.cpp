#include <iostream>

#include "client/commands/commands.hpp"
#include "client/job_id.hpp"
#include "client/message_json.hpp"

namespace dccast::client::commands {
namespace {

struct Options {
  std::vector<std::string> ids;
  bool cancel = false;
  bool json = false;
};

/// A job that is being cancelled is deleted once its worker has ended.
void delete_job(Connection& connection, const std::string& id) {
  constexpr std::chrono::milliseconds pause{200};
  constexpr std::chrono::seconds longest{120};  // a worker that does not end is killed before
  const auto end = std::chrono::steady_clock::now() + longest;
  v1::DeleteJobRequest request;
  request.set_id(id);
  for (;;) {
    v1::DeleteJobResponse response;
    const grpc::Status status = connection.try_once(&Stub::DeleteJob, request, response);
    const bool again = status.error_code() == grpc::StatusCode::ABORTED;
    if (!again || std::chrono::steady_clock::now() > end) return check(status, connection.server());
    connection.interruption().sleep(pause);
  }
}

void cancel_job(Connection& connection, const std::string& id) {
  v1::CancelJobRequest request;
  request.set_id(id);
  connection.call(&Stub::CancelJob, request);
}

ExitCode run(const Options& options, Program& program) {
  Connection connection = program.connect();
  for (const std::string& id : resolve_jobs(connection, options.ids)) {
    if (options.cancel) cancel_job(connection, id);
    delete_job(connection, id);
    if (options.json)
      std::cout << Json{{"id", id}, {"deleted", true}}.dump() << std::endl;
    else
      std::cerr << "deleted " << id << '\n';
  }
  return ExitCode::done;
}

}  // namespace

void add_delete(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command = subcommand(
      app, "delete", "Remove ended jobs and their files; waits for one that is being cancelled",
      "dccast delete JOB\n  dccast delete --cancel JOB JOB");
  command->add_option("JOB", options->ids, job_help)->required();
  command->add_flag("--cancel", options->cancel, "Cancel jobs that have not ended first");
  command->add_flag("--json", options->json, "As JSON, one a line");
  command->callback([options, &program] {
    program.action = [options, &program] { return run(*options, program); };
  });
}

}  // namespace dccast::client::commands
