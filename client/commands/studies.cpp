#include <algorithm>
#include <iostream>

#include "client/cli/common_options.hpp"
#include "client/commands/commands.hpp"
#include "client/model/json.hpp"
#include "client/session/download.hpp"
#include "client/session/studies.hpp"
#include "client/text/job_text.hpp"
#include "client/text/study_text.hpp"
#include "client/text/table.hpp"

namespace dccast::client::commands {
namespace {

struct Options {
  int limit = 50;
  std::string id;
  std::string reason;
  std::string output = "study.h5";
  bool failed = false;
  bool force = false;
  bool json = false;
};

ExitCode list(const Options& options, Program& program) {
  Connection connection = program.connect();
  const auto studies = list_studies(connection, options.limit);
  if (options.json) {
    Json json = Json::array();
    for (const v1::Study& study : studies) json.push_back(to_json(study));
    std::cout << json.dump() << '\n';
    return ExitCode::done;
  }
  std::vector<std::string> ids;
  for (const v1::Study& study : studies) ids.push_back(study.id());
  const std::size_t length = short_id_length(ids);
  render::Table table({"STUDY", "STATE", "RUNS", "PLAN", "CREATED", "TITLE"});
  for (const v1::Study& study : studies)
    table.add({study.id().substr(0, length), render::state_text(study.state()),
               render::progress_text(study), render::plan_text(study),
               render::time_text(study.create_time()), study.title()});
  if (studies.empty())
    std::cerr << "no studies\n";
  else
    std::cout << table.text() << std::flush;
  return ExitCode::done;
}

ExitCode print(const Options& options, const v1::Study& study) {
  std::cout << (options.json ? to_json(study).dump() + "\n" : render::study_sheet(study))
            << std::flush;
  return ExitCode::done;
}

ExitCode show(const Options& options, Program& program) {
  Connection connection = program.connect();
  v1::GetStudyRequest request;
  request.set_id(resolve_study(connection, options.id));
  return print(options, connection.call(&Stub::GetStudy, request));
}

ExitCode fetch(const Options& options, Program& program) {
  require_free(options.output, options.force);
  Connection connection = program.connect();
  const std::string id = resolve_study(connection, options.id);
  const Download table = download_study(connection, id, options.output, std::cerr);
  if (options.json)
    std::cout << Json{{"id", id},
                      {"file", options.output},
                      {"bytes", table.bytes},
                      {"sha256", table.sha256}}
                     .dump()
              << '\n';
  else
    std::cout << table.sha256 << "  " << options.output << '\n';
  return ExitCode::done;
}

ExitCode cancel(const Options& options, Program& program) {
  Connection connection = program.connect();
  v1::CancelStudyRequest request;
  request.set_id(resolve_study(connection, options.id));
  request.set_reason(options.reason);
  return print(options, connection.call(&Stub::CancelStudy, request));
}

ExitCode resume(const Options& options, Program& program) {
  Connection connection = program.connect();
  v1::ResumeStudyRequest request;
  request.set_id(resolve_study(connection, options.id));
  request.set_failed(options.failed);
  return print(options, connection.call(&Stub::ResumeStudy, request));
}

ExitCode remove(const Options& options, Program& program) {
  Connection connection = program.connect();
  v1::DeleteStudyRequest request;
  request.set_id(resolve_study(connection, options.id));
  connection.call_once(&Stub::DeleteStudy, request);
  if (options.json)
    std::cout << Json{{"id", request.id()}, {"deleted", true}}.dump() << '\n';
  else
    std::cerr << "deleted " << request.id() << " and its jobs\n";
  return ExitCode::done;
}

using Action = ExitCode (*)(const Options&, Program&);

cli::Command add_action(const cli::Command& command, Program& program,
                        const std::shared_ptr<Options>& options, const std::string& name,
                        const std::string& description, Action action) {
  const cli::Command added = command.command(name, description);
  added.option("STUDY", options->id, study_help).required();
  added.json(options->json);
  added.action([options, &program, action] { return action(*options, program); });
  return added;
}

}  // namespace

void add_studies(cli::CommandLine& line, Program& program) {
  const auto options = std::make_shared<Options>();
  const cli::Command command = line.command(
      "studies", "List studies, newest first; show, fetch, cancel, resume or delete one",
      "dccast studies\n  dccast studies cancel STUDY\n  dccast studies resume --failed "
      "STUDY");
  command.option("-n,--limit", options->limit, "At most this many")
      .between(1, 1000000)
      .show_default();
  command.json(options->json);
  add_action(command, program, options, "show", "Everything about one study", show);
  const cli::Command fetched = add_action(
      command, program, options, "fetch",
      "Fetch values, curls, curves, states and findings of all runs as HDF5 (docs/studies.md)",
      fetch);
  fetched.option("-o,--output", options->output, "File to write").show_default();
  add_force_flag(fetched, options->force);
  add_action(command, program, options, "cancel", "Cancel what has not ended", cancel)
      .option("--reason", options->reason, "Kept with the jobs");
  add_action(command, program, options, "resume",
             "Queue again what was cancelled, or lost to its worker or a full disk", resume)
      .flag("--failed", options->failed, "Also runs that failed by their own case");
  add_action(command, program, options, "delete", "Remove an ended study and its jobs", remove);
  command.action([options, &program] { return list(*options, program); });
}

}  // namespace dccast::client::commands
