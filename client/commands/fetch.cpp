#include <fstream>
#include <iostream>
#include <sstream>

#include "client/commands/commands.hpp"
#include "client/commands/output_file.hpp"
#include "client/download.hpp"
#include "client/job_id.hpp"
#include "client/message_json.hpp"

namespace dccast::client::commands {
namespace {

namespace fs = std::filesystem;

struct Options {
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
  if (!(std::ofstream(sidecar, std::ios::binary | std::ios::trunc) << text))
    throw CommandFailed(ExitCode::not_found, "cannot write " + sidecar.string());
}

ExitCode run(const Options& options, Program& program) {
  Connection connection = program.connect();
  const std::string id = resolve_job(connection, options.id);
  const fs::path file = options.output;
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

}  // namespace

void add_fetch(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command = subcommand(app, "fetch",
                                       "Fetch the results of a job that has succeeded: the HDF5 "
                                       "file and its XDMF sidecar for ParaView",
                                       "dccast fetch JOB -o results.h5");
  command->add_option("JOB", options->id, job_help)->required();
  command
      ->add_option("-o,--output", options->output,
                   "File to write; an interrupted FILE.part is continued")
      ->capture_default_str();
  add_force_flag(*command, options->force);
  command->add_flag("--json", options->json, "What was written, as JSON");
  command->callback([options, &program] {
    program.action = [options, &program] { return run(*options, program); };
  });
}

}  // namespace dccast::client::commands
