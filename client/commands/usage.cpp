// Processor time and disk space of jobs, and the files kept besides their results.
#include <iostream>
#include <map>

#include "client/commands/commands.hpp"
#include "client/session/download.hpp"
#include "client/session/jobs.hpp"
#include "client/text/job_text.hpp"
#include "client/text/progress.hpp"
#include "client/text/table.hpp"

namespace dccast::client {
namespace {

struct UsageOptions {
  std::string by = "owner";
  std::string since;
  bool json = false;
};

struct Usage {
  int jobs = 0, succeeded = 0, failed = 0;
  double processor_s = 0.0;
};

/// A job with several labels counts for each of them.
std::vector<std::string> groups_of(const v1::Job& job, const std::string& by) {
  if (by == "owner") return {job.owner()};
  if (by == "study") return {job.study()};
  if (by == "label") return {job.labels().begin(), job.labels().end()};
  return {state_text(job.state())};
}

ExitCode run(const UsageOptions& options, Program& program) {
  constexpr int most_jobs = 1'000'000;  // the most that a daemon keeps waiting
  Connection connection = program.connect();
  v1::ListJobsRequest request;
  if (!options.since.empty()) request.mutable_since()->set_seconds(seconds_of_past(options.since));

  std::map<std::string, Usage> usages;
  for (const v1::Job& job : list_jobs(connection, request, most_jobs).jobs)
    for (const std::string& group : groups_of(job, options.by)) {
      Usage& usage = usages[group];
      ++usage.jobs;
      usage.succeeded += job.state() == v1::SUCCEEDED;
      usage.failed += job.state() == v1::FAILED;
      usage.processor_s += job.last_step().process_s();
    }

  Table table({options.by, ">jobs", ">succeeded", ">failed", ">processor time"});
  Json list = Json::array();
  for (const auto& [group, usage] : usages) {
    table.add({group.empty() ? "-" : group, std::to_string(usage.jobs),
               std::to_string(usage.succeeded), std::to_string(usage.failed),
               duration_text(usage.processor_s)});
    list.push_back({{options.by, group},
                    {"jobs", usage.jobs},
                    {"succeeded", usage.succeeded},
                    {"failed", usage.failed},
                    {"processor_s", usage.processor_s}});
  }

  std::cout << (options.json ? list.dump() + "\n" : table.text());
  return ExitCode::done;
}

/// Adds a command that prints a file of a job unchanged.
void add_file_command(CommandLine& line, Program& program, const char* name,
                      const char* description, const char* example, const char* file) {
  const auto id = std::make_shared<std::string>();
  const Command command = line.command(name, description, example);
  command.option("JOB", *id, job_help, required);
  command.action([id, file, &program] {
    Connection connection = program.connect();
    std::cout << read_file_of_job(connection, resolve_job(connection, *id), file) << std::flush;
    return ExitCode::done;
  });
}

}  // namespace

void add_usage(CommandLine& line, Program& program) {
  const auto [command, options] = declare<UsageOptions>(
      line, program, run, "usage", "Jobs and processor time by owner, study, label or state",
      "dccast usage --by owner --since 2026-11-01");
  command.option("--by", options.by, "What jobs are counted by",
                 {.show_default = true, .one_of = {"owner", "study", "label", "state"}});
  command.option("--since", options.since,
                 "Only jobs submitted since: today, yesterday, \"3 h\", \"2 d\", 2026-11-20");
  command.json(options.json);
}

void add_case(CommandLine& line, Program& program) {
  add_file_command(line, program, "case", "The case of a job as it was submitted, byte by byte",
                   "dccast case JOB > my.toml", "case.toml");
}

void add_logs(CommandLine& line, Program& program) {
  add_file_command(line, program, "logs", "What the worker of a job has written about itself",
                   "dccast logs JOB", "worker.log");
}

}  // namespace dccast::client
