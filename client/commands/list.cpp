#include <iostream>
#include <map>
#include <set>

#include "client/commands/commands.hpp"
#include "client/job_listing.hpp"
#include "client/message_json.hpp"
#include "client/render/job_columns.hpp"

namespace dccast::client::commands {
namespace {

struct Options {
  std::vector<std::string> states;
  std::vector<std::string> labels;
  std::vector<std::string> columns;
  std::string study;
  std::string owner;
  int limit = 50;
  bool ids = false;
  bool json = false;
};

const std::map<std::string, v1::JobState> state_names{
    {"queued", v1::QUEUED},       {"running", v1::RUNNING}, {"paused", v1::PAUSED},
    {"succeeded", v1::SUCCEEDED}, {"failed", v1::FAILED},   {"cancelled", v1::CANCELLED}};

v1::ListJobsRequest request_of(const Options& options) {
  v1::ListJobsRequest request;
  for (const std::string& state : options.states) request.add_states(state_names.at(state));
  request.mutable_labels()->Assign(options.labels.begin(), options.labels.end());
  request.set_study(options.study);
  request.set_owner(options.owner);
  return request;
}

/// Why jobs are held, each reason once.
void print_holds(const std::vector<v1::Job>& jobs) {
  std::set<std::string> reasons;
  for (const v1::Job& job : jobs)
    if (!job.held().empty()) reasons.insert(job.held());
  for (const std::string& reason : reasons) std::cerr << "held: " << reason << '\n';
}

void print_json(const std::vector<v1::Job>& jobs) {
  Json list = Json::array();
  for (const v1::Job& job : jobs) list.push_back(to_json(job));
  std::cout << list.dump() << '\n';
}

ExitCode run(const Options& options, Program& program) {
  Connection connection = program.connect();
  const JobListing listing = list_some_jobs(connection, request_of(options), options.limit);
  if (options.json)
    print_json(listing.jobs);
  else if (options.ids)
    for (const v1::Job& job : listing.jobs) std::cout << job.id() << '\n';
  else if (!listing.jobs.empty())
    std::cout << render::job_table(listing.jobs, options.columns) << std::flush;
  if (listing.jobs.empty()) std::cerr << "no jobs\n";
  if (listing.more)
    std::cerr << "these are the newest " << listing.jobs.size() << "; there are more: --limit\n";
  if (!options.json) print_holds(listing.jobs);
  return ExitCode::done;
}

constexpr const char* examples =
    "dccast list --state running,queued\n"
    "  dccast list --label trial-7 --columns job,curl,changes\n"
    "  dccast list --json | jq -r '.[] | select(.findings | length > 0) | .id'\n"
    "\n"
    "JOB is the beginning of an id that no other job listed has; every command takes it.";

}  // namespace

void add_list(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command = subcommand(app, "list", "List jobs, newest first", examples);
  std::vector<std::string> names;
  for (const auto& [name, state] : state_names) names.push_back(name);
  command->add_option("-s,--state", options->states, "Only jobs in these states")
      ->delimiter(',')
      ->check(CLI::IsMember(names));
  command->add_option("--label", options->labels, "Only jobs with this label; repeatable")
      ->delimiter(',')
      ->allow_extra_args(false);
  command->add_option("--owner", options->owner, "Only the jobs of this user");
  command->add_option("--study", options->study, "Only the jobs of this study");
  command->add_option("-c,--columns", options->columns, "Columns to show")
      ->delimiter(',')
      ->check(CLI::IsMember(render::job_columns()));
  command->add_option("-n,--limit", options->limit, "At most this many")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  command->add_flag("--ids", options->ids, "Print only complete ids, one per line");
  command->add_flag("--json", options->json, "As JSON");
  command->callback([options, &program] {
    program.action = [options, &program] { return run(*options, program); };
  });
}

}  // namespace dccast::client::commands
