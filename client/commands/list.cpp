#include <iostream>
#include <map>
#include <set>

#include "client/commands/commands.hpp"
#include "client/job_listing.hpp"
#include "client/message_json.hpp"
#include "client/render/findings.hpp"
#include "client/render/job_text.hpp"
#include "client/render/table.hpp"

namespace dccast::client::commands {
namespace {

struct Options {
  std::vector<std::string> states;
  std::string study;
  int limit = 50;
  bool json = false;
};

const std::map<std::string, v1::JobState> state_names{
    {"queued", v1::QUEUED},       {"running", v1::RUNNING}, {"paused", v1::PAUSED},
    {"succeeded", v1::SUCCEEDED}, {"failed", v1::FAILED},   {"cancelled", v1::CANCELLED}};

v1::ListJobsRequest request_of(const Options& options) {
  v1::ListJobsRequest request;
  for (const std::string& state : options.states) request.add_states(state_names.at(state));
  request.set_study(options.study);
  return request;
}

/// Why jobs are held, each reason once.
void print_holds(const std::vector<v1::Job>& jobs) {
  std::set<std::string> reasons;
  for (const v1::Job& job : jobs)
    if (!job.held().empty()) reasons.insert(job.held());
  for (const std::string& reason : reasons) std::cerr << "held: " << reason << '\n';
}

ExitCode run(const Options& options, Program& program) {
  Connection connection = program.connect();
  const std::vector<v1::Job> jobs = list_jobs(connection, request_of(options), options.limit);
  if (options.json) {
    Json list = Json::array();
    for (const v1::Job& job : jobs) list.push_back(to_json(job));
    std::cout << list.dump() << '\n';
    return ExitCode::done;
  }
  render::Table table({"JOB", "STATE", ">DONE", "FINDINGS", "CREATED", "TITLE"});
  for (const v1::Job& job : jobs)
    table.add(
        {job.id(), render::full_state_text(job),
         job.has_last_step() ? render::fixed(100.0 * job.last_step().progress(), 0) + " %" : "-",
         job.findings().empty() ? "-" : render::findings_count(job.findings()),
         render::time_text(job.create_time()), job.title()});
  if (jobs.empty())
    std::cerr << "no jobs\n";
  else
    std::cout << table.text() << std::flush;
  print_holds(jobs);
  return ExitCode::done;
}

}  // namespace

void add_list(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command =
      subcommand(app, "list", "List jobs, newest first", "dccast list --state running,queued");
  std::vector<std::string> names;
  for (const auto& [name, state] : state_names) names.push_back(name);
  command->add_option("-s,--state", options->states, "Only jobs in these states")
      ->delimiter(',')
      ->check(CLI::IsMember(names));
  command->add_option("--study", options->study, "Only the jobs of this study");
  command->add_option("-n,--limit", options->limit, "At most this many")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  command->add_flag("--json", options->json, "As JSON");
  command->callback([options, &program] {
    program.action = [options, &program] { return run(*options, program); };
  });
}

}  // namespace dccast::client::commands
