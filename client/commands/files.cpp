#include <fstream>
#include <iostream>
#include <sstream>

#include "client/cli/common_options.hpp"
#include "client/commands/commands.hpp"
#include "client/html/pages.hpp"
#include "client/model/json.hpp"
#include "client/session/download.hpp"
#include "client/session/jobs.hpp"
#include "client/session/pdf.hpp"

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

ExitCode run(const ReportOptions& options, Program& program) {
  if (options.output != "-") require_free(options.output, options.force);
  Connection connection = program.connect();
  v1::GetJobRequest request;
  request.set_id(resolve_job(connection, options.id));
  const v1::Job job = connection.call(&Stub::GetJob, request);
  const std::string page = render::report_of(connection, job, std::cerr);
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
