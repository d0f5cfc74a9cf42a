#include <algorithm>
#include <cmath>
#include <fstream>
#include <iostream>
#include <sstream>

#include "client/cli/common_options.hpp"
#include "client/commands/commands.hpp"
#include "client/html/report_page.hpp"
#include "client/model/json.hpp"
#include "client/session/download.hpp"
#include "client/session/jobs.hpp"
#include "client/session/pdf.hpp"
#include "client/session/queries.hpp"
#include "client/session/studies.hpp"

namespace dccast::client::commands {
namespace {

namespace fs = std::filesystem;

struct FetchOptions {
  std::string id;
  std::string output = "results.h5";
  bool force = false;
  bool json = false;
};

std::string xml_escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) escaped += c == '&' ? "&amp;" : c == '<' ? "&lt;" : std::string(1, c);
  return escaped;
}

/// The sidecar names its HDF5 file without a folder, so that both can move together; the file may
/// have been fetched under another name.
void point_sidecar_at(const fs::path& sidecar, const fs::path& results) {
  std::ifstream stream(sidecar, std::ios::binary);
  std::ostringstream content;
  content << stream.rdbuf();
  std::string text = content.str();
  const std::string named = "results.h5:";
  const std::string name = xml_escaped(results.filename().string()) + ":";
  for (auto at = text.find(named); at != std::string::npos; at = text.find(named, at + name.size()))
    text.replace(at, named.size(), name);
  stream.close();
  write_file(sidecar, text);
}

/// Where the results go: a file, or results.h5 in a folder.
fs::path target_of(const std::string& output) {
  const auto refuse = [&](const std::string& why) {
    throw CommandFailed(ExitCode::invalid, "-o \"" + output + "\": " + why);
  };
  std::error_code error;
  if (output.empty()) refuse("give a file or a folder");
  if (output == "-") refuse("results are two files, which standard output cannot hold");
  const fs::path given = output;
  if (fs::is_directory(given, error)) return given / "results.h5";
  if (fs::exists(given, error) && !fs::is_regular_file(given, error))
    refuse("this is no file, and results would take its place");
  if (given.extension() == ".xdmf")
    refuse("the .xdmf is written beside it; give the name of the HDF5 file");
  return given;
}

ExitCode run(const FetchOptions& options, Program& program) {
  const fs::path file = target_of(options.output);
  Connection connection = program.connect();
  const std::string id = resolve_job(connection, options.id);
  const fs::path sidecar = fs::path(file).replace_extension(".xdmf");
  for (const fs::path& written : {file, sidecar}) require_free(written, options.force);
  const Download results = download(connection, id, "results.h5", file, std::cerr);
  fs::remove(sidecar.string() + ".part");
  download(connection, id, "results.xdmf", sidecar, std::cerr);
  point_sidecar_at(sidecar, file);
  if (options.json)
    std::cout << Json{{"job", id},
                      {"file", file.string()},
                      {"bytes", results.bytes},
                      {"sha256", results.sha256},
                      {"resumed_at", results.resumed_at},
                      {"xdmf", sidecar.string()}}
                     .dump()
              << '\n';
  else
    std::cout << results.sha256 << "  " << file.string() << '\n';
  std::cerr << "fetched " << file.string() << " (" << results.bytes
            << " bytes, checksum verified) and " << sidecar.string() << '\n';
  return ExitCode::done;
}

struct ReportOptions {
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

ExitCode run(const ReportOptions& options, Program& program) {
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
  if (fs::path(options.output).extension() == ".pdf")
    print_pdf(page, options.output);
  else
    write_file(options.output, page);
  if (options.json)
    std::cout << Json{{"job", job.id()},
                      {"file", options.output},
                      {"bytes", fs::file_size(options.output)}}
                     .dump()
              << '\n';
  else
    std::cout << options.output << '\n';
  return ExitCode::done;
}

}  // namespace

void add_fetch(cli::CommandLine& line, Program& program) {
  const auto options = std::make_shared<FetchOptions>();
  const cli::Command command =
      line.command("fetch",
                   "Fetch the results of a job that has succeeded: the HDF5 "
                   "file and its XDMF sidecar for ParaView",
                   "dccast fetch JOB -o results.h5");
  command.option("JOB", options->id, job_help).required();
  command
      .option("-o,--output", options->output,
              "File or folder to write to; an interrupted FILE.part is continued")
      .show_default();
  add_force_flag(command, options->force);
  command.json(options->json, "What was written, as JSON");
  command.action([options, &program] { return run(*options, program); });
}

void add_report(cli::CommandLine& line, Program& program) {
  const auto options = std::make_shared<ReportOptions>();
  const cli::Command command = line.command(
      "report",
      "Write one HTML page about a job: findings, curl, recipe, histories, the last frame, checks",
      "dccast report JOB -o report.html");
  command.option("JOB", options->id, job_help).required();
  command
      .option("-o,--output", options->output,
              "File to write, HTML or with Chromium also .pdf; - for standard output")
      .show_default();
  add_force_flag(command, options->force);
  command.json(options->json, "What was written, as JSON");
  command.action([options, &program] { return run(*options, program); });
}

}  // namespace dccast::client::commands
