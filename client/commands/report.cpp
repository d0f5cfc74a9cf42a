#include <fstream>
#include <iostream>

#include "client/commands/commands.hpp"
#include "client/commands/output_file.hpp"
#include "client/job_id.hpp"
#include "client/job_result.hpp"
#include "client/message_json.hpp"
#include "client/render/report_page.hpp"
#include "client/study_reading.hpp"

namespace dccast::client::commands {
namespace {

struct Options {
  std::string id;
  std::string output = "report.html";
  bool force = false;
  bool json = false;
};

/// With the last frame; without it when the job has none.
v1::QueryResultResponse query(Connection& connection, const std::string& id) {
  v1::QueryResultResponse result;
  const grpc::Status status = try_query_result(connection, id, true, result);
  if (status.error_code() != grpc::StatusCode::FAILED_PRECONDITION) {
    check(status, connection.server());
    return result;
  }
  std::cerr << "dccast: " << status.error_message() << "; the report goes without a picture of the slab\n";
  return query_result(connection, id);
}

ExitCode run(const Options& options, Program& program) {
  if (options.output != "-") require_free(options.output, options.force);
  Connection connection = program.connect();
  v1::GetJobRequest request;
  request.set_id(resolve_job(connection, options.id));
  const v1::Job job = connection.call(&Stub::GetJob, request);
  const v1::QueryResultResponse result = query(connection, job.id());
  const Study study = study_around(connection, job);
  const std::string page = render::report_page(job, result, study);
  if (options.output == "-") {
    std::cout << page;
    return ExitCode::done;
  }
  std::ofstream stream(options.output, std::ios::binary);
  if (!(stream << page << std::flush))
    throw CommandFailed(ExitCode::not_found, "cannot write " + options.output);
  if (options.json)
    std::cout << Json{{"job", job.id()}, {"file", options.output}, {"bytes", page.size()}}.dump()
              << '\n';
  else
    std::cout << options.output << '\n';
  return ExitCode::done;
}

}  // namespace

void add_report(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command =
      subcommand(app, "report",
                 "Write one HTML page about a job: findings, curl, recipe, histories, the last frame, checks",
                 "dccast report JOB -o report.html");
  command->add_option("JOB", options->id, job_help)->required();
  command->add_option("-o,--output", options->output, "File to write; - for standard output")
      ->capture_default_str();
  add_force_flag(*command, options->force);
  command->add_flag("--json", options->json, "What was written, as JSON");
  command->callback([options, &program] {
    program.action = [options, &program] { return run(*options, program); };
  });
}

}  // namespace dccast::client::commands
