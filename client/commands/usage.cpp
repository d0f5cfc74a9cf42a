// Processor time and disk space of jobs, and the files kept besides their results.
#include <algorithm>
#include <chrono>
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

struct LogsOptions {
  std::string id;
  bool follow = false;
};

/// Prints what happened to a job besides its steps, with time and number of the attempt.
class History {
public:
  void print(const v1::JobEvent& event) {
    if (event.has_step()) return;
    if (event.has_state_change()) attempt_ = std::max(attempt_, event.state_change().attempt());
    const std::string attempt = attempt_ > 0 ? "attempt " + std::to_string(attempt_) : "-";
    std::cout << time_text(event.time()) << "  " << attempt << "  " << event_line(event)
              << std::endl;
  }

private:
  int attempt_ = 0;
};

/// The events so far of a job that has not ended: those before the call, or all of a moment.
void print_history_so_far(Connection& connection, const std::string& id) {
  constexpr std::chrono::seconds longest{2};
  const auto now = std::chrono::system_clock::now();
  grpc::ClientContext context;
  context.set_deadline(now + longest);
  const Interruption::Call call(connection.interruption(), context);
  v1::WatchJobRequest request;
  request.set_id(id);
  const auto reader = connection.stub().WatchJob(&context, request);

  History history;
  v1::JobEvent event;
  while (reader->Read(&event)) {
    if (event.time().seconds() > std::chrono::system_clock::to_time_t(now)) break;
    history.print(event);
  }
  context.TryCancel();
  const grpc::Status status = reader->Finish();
  if (connection.interruption().came()) throw Interrupted("");
  if (status.error_code() != grpc::DEADLINE_EXCEEDED && status.error_code() != grpc::CANCELLED)
    check(status, connection.server());
}

/// What the workers wrote; empty before the first one.
std::string worker_log(Connection& connection, const std::string& id) try {
  return read_file_of_job(connection, id, "worker.log");
} catch (const CommandFailed& failure) {
  if (failure.code() != ExitCode::not_found) throw;
  return {};
}

ExitCode run(const LogsOptions& options, Program& program) {
  Connection connection = program.connect();
  const std::string id = resolve_job(connection, options.id);
  const v1::Job job = connection.call(&Stub::GetJob, id);

  if (options.follow || job.has_end_time()) {
    History history;
    follow_job(
        connection, id, 1, [&](const v1::JobEvent& event) { history.print(event); }, std::cerr);
  } else {
    print_history_so_far(connection, id);
  }
  if (const std::string log = worker_log(connection, id); !log.empty())
    std::cout << "\nwritten by its workers:\n" << log << std::flush;
  return ExitCode::done;
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
  const auto id = std::make_shared<std::string>();
  const Command command = line.command(
      "case", "The case of a job as it was submitted, byte by byte", "dccast case JOB > my.toml");
  command.option("JOB", *id, job_help, required);
  command.action([id, &program] {
    Connection connection = program.connect();
    std::cout << read_file_of_job(connection, resolve_job(connection, *id), "case.toml")
              << std::flush;
    return ExitCode::done;
  });
}

void add_logs(CommandLine& line, Program& program) {
  const auto [command, options] = declare<LogsOptions>(
      line, program, run, "logs",
      "What happened to a job: attempts, deaths, pauses with their times, and what its workers "
      "wrote",
      "dccast logs JOB\n  dccast logs --follow last");
  command.option("JOB", options.id, job_help, required);
  command.flag("-f,--follow", options.follow, "Until the job has ended");
}

}  // namespace dccast::client
