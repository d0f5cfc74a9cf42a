#include <algorithm>
#include <iostream>

#include "client/commands/commands.hpp"
#include "client/commands/output_file.hpp"
#include "client/download.hpp"
#include "client/message_json.hpp"
#include "client/render/job_text.hpp"
#include "client/render/study_text.hpp"
#include "client/render/table.hpp"

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

std::vector<v1::Study> all_studies(Connection& connection, int limit) {
  constexpr int largest_page = 1000;  // service.proto
  std::vector<v1::Study> studies;
  v1::ListStudiesRequest request;
  do {
    request.set_page_size(std::min(largest_page, limit - static_cast<int>(studies.size())));
    const auto page = connection.call(&Stub::ListStudies, request);
    studies.insert(studies.end(), page.studies().begin(), page.studies().end());
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty() && static_cast<int>(studies.size()) < limit);
  return studies;
}

ExitCode list(const Options& options, Program& program) {
  Connection connection = program.connect();
  const auto studies = all_studies(connection, options.limit);
  if (options.json) {
    Json json = Json::array();
    for (const v1::Study& study : studies) json.push_back(to_json(study));
    std::cout << json.dump() << '\n';
    return ExitCode::done;
  }
  render::Table table({"STUDY", "STATE", "RUNS", "PLAN", "CREATED", "TITLE"});
  for (const v1::Study& study : studies)
    table.add({study.id(), render::state_text(study.state()), render::progress_text(study),
               render::plan_text(study), render::time_text(study.create_time()), study.title()});
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
  request.set_id(options.id);
  return print(options, connection.call(&Stub::GetStudy, request));
}

ExitCode fetch(const Options& options, Program& program) {
  require_free(options.output, options.force);
  Connection connection = program.connect();
  const Download table = download_study(connection, options.id, options.output, std::cerr);
  if (options.json)
    std::cout << Json{{"id", options.id},
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
  request.set_id(options.id);
  request.set_reason(options.reason);
  return print(options, connection.call(&Stub::CancelStudy, request));
}

ExitCode resume(const Options& options, Program& program) {
  Connection connection = program.connect();
  v1::ResumeStudyRequest request;
  request.set_id(options.id);
  request.set_failed(options.failed);
  return print(options, connection.call(&Stub::ResumeStudy, request));
}

ExitCode remove(const Options& options, Program& program) {
  Connection connection = program.connect();
  v1::DeleteStudyRequest request;
  request.set_id(options.id);
  connection.call_once(&Stub::DeleteStudy, request);
  if (options.json)
    std::cout << Json{{"id", options.id}, {"deleted", true}}.dump() << '\n';
  else
    std::cerr << "deleted " << options.id << " and its jobs\n";
  return ExitCode::done;
}

using Action = ExitCode (*)(const Options&, Program&);

CLI::App* add_action(CLI::App& command, Program& program, const std::shared_ptr<Options>& options,
                     const std::string& name, const std::string& description, Action action) {
  CLI::App* const added = command.add_subcommand(name, description);
  added->add_option("STUDY", options->id, "Study id")->required();
  added->add_flag("--json", options->json, "As JSON");
  added->callback([options, &program, action] {
    program.action = [options, &program, action] { return action(*options, program); };
  });
  return added;
}

}  // namespace

void add_studies(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command = subcommand(
      app, "studies", "List studies, newest first; show, fetch, cancel, resume or delete one",
      "dccast studies\n  dccast studies cancel STUDY\n  dccast studies resume --failed "
      "STUDY");
  command->add_option("-n,--limit", options->limit, "At most this many")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  command->add_flag("--json", options->json, "As JSON");
  add_action(*command, program, options, "show", "Everything about one study", show);
  CLI::App* const fetched = add_action(
      *command, program, options, "fetch",
      "Fetch values, curls, curves, states and findings of all runs as HDF5 (docs/studies.md)",
      fetch);
  fetched->add_option("-o,--output", options->output, "File to write")->capture_default_str();
  add_force_flag(*fetched, options->force);
  add_action(*command, program, options, "cancel", "Cancel what has not ended", cancel)
      ->add_option("--reason", options->reason, "Kept with the jobs");
  add_action(*command, program, options, "resume",
             "Queue again what was cancelled, or lost to its worker or a full disk", resume)
      ->add_flag("--failed", options->failed, "Also runs that failed by their own case");
  add_action(*command, program, options, "delete", "Remove an ended study and its jobs", remove);
  command->require_subcommand(0, 1);
  command->callback([options, command, &program] {
    if (!command->get_subcommands().empty()) return;
    program.action = [options, &program] { return list(*options, program); };
  });
}

}  // namespace dccast::client::commands
