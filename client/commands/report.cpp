#include <algorithm>
#include <cmath>
#include <fstream>
#include <iostream>

#include "client/commands/commands.hpp"
#include "client/commands/output_file.hpp"
#include "client/frame_fetch.hpp"
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

/// The result with the last frame; without it if the job has none or it is too large for a
/// response.
v1::QueryResultResponse query(Connection& connection, const std::string& id) {
  v1::QueryResultResponse result;
  const grpc::Status status = try_query_result(connection, id, true, result);
  const auto code = status.error_code();
  if (code != grpc::StatusCode::FAILED_PRECONDITION &&
      code != grpc::StatusCode::RESOURCE_EXHAUSTED) {
    check(status, connection.server());
    return result;
  }
  std::cerr << "dccast: " << status.error_message()
            << "; the report goes without a picture of the slab\n";
  return query_result(connection, id);
}

/// Number of frames that keep the page small enough to be passed on: half a megabyte.
FrameSeries frames_for_slider(Connection& connection, const std::string& id,
                              const v1::QueryResultResponse& result) {
  constexpr int most_frames = 25;
  constexpr double most_bytes = 500e3;
  if (!result.has_frame()) return {};
  // The slab grows: a frame has half the last one's nodes on average, and of a quarter slab it is
  // the surface that counts. Eleven characters a node.
  const double nodes = result.frame().temperature_c_size();
  const double seen = result.frame().dimension() == 3 ? 6.0 * std::pow(nodes, 2.0 / 3.0) : nodes;
  const int fitting = static_cast<int>(most_bytes / (0.5 * 11.0 * seen + 1.0));
  return fetch_frames(connection, id, result, std::clamp(fitting, 2, most_frames));
}

ExitCode run(const Options& options, Program& program) {
  if (options.output != "-") require_free(options.output, options.force);
  Connection connection = program.connect();
  v1::GetJobRequest request;
  request.set_id(resolve_job(connection, options.id));
  const v1::Job job = connection.call(&Stub::GetJob, request);
  const v1::QueryResultResponse result = query(connection, job.id());
  const Study study = study_around(connection, job);
  const FrameSeries series = frames_for_slider(connection, job.id(), result);
  const std::string page = render::report_page(job, result, study, series);
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
  CLI::App* const command = subcommand(
      app, "report",
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
