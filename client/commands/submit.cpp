#include <algorithm>
#include <filesystem>
#include <iostream>

#include "client/cli/common_options.hpp"
#include "client/commands/commands.hpp"
#include "client/model/answer.hpp"
#include "client/session/case_faults.hpp"
#include "client/session/jobs.hpp"
#include "client/text/findings.hpp"
#include "client/text/job_text.hpp"
#include "client/text/progress.hpp"
#include "client/text/table.hpp"
#include "client/text/watch_output.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/values/digests.hpp"
#include "proto/values/printable.hpp"

namespace dccast::client {
namespace {

struct SubmitOptions {
  std::vector<std::string> files;
  std::string from;
  std::vector<std::string> after;
  std::vector<std::string> set;
  std::vector<std::string> labels;
  int after_end = v1::AWAITED_SUCCESS;
  std::string request_id;
  std::string begin, time_limit, mail, notify;
  int priority = v1::NORMAL;
  bool watch = false;
  bool json = false;
  bool strict = false;
};

ExitCode refuse_submission(const CaseUnderCheck& checked, bool json) {
  if (json) print_line(faults_json(checked));
  print_faults(checked, std::cerr);
  std::cerr << "dccast: not submitted, " << checked.faults.size()
            << (checked.faults.size() == 1 ? " fault\n" : " faults\n");
  return ExitCode::invalid;
}

void require_source(const SubmitOptions& options) {
  if (options.files.empty() == options.from.empty())
    throw invalid("give either FILEs or --from JOB");
  if (options.files.size() > 1 && options.watch)
    throw invalid("--watch goes with one FILE; " + std::to_string(options.files.size()) +
                  " are given");
}

/// Checks all cases; if one has faults, none is submitted. @return empty if one has faults, which
/// have been printed
std::optional<std::vector<CaseUnderCheck>> examined_cases(const SubmitOptions& options,
                                                          Connection& connection) {
  std::vector<CaseUnderCheck> cases;
  for (const std::string& file : options.files)
    cases.push_back(read_case(file, changes_of(options.set)));
  if (!options.from.empty())
    cases.push_back(read_case_of_job(connection, resolve_job(connection, options.from),
                                     changes_of(options.set)));

  // All faults of all files at once.
  bool sound = true;
  for (CaseUnderCheck& checked : cases) {
    check_with_server(checked, connection);
    if (!checked.faults.empty()) refuse_submission(checked, options.json);
    sound = sound && checked.faults.empty();
  }

  if (!sound) return std::nullopt;
  for (const CaseUnderCheck& checked : cases)
    for (const v1::Fault& warning : checked.warnings)
      std::cerr << "warning: " << describe(warning, checked.read.source) << '\n';
  return cases;
}

/// The request id of one case: the same file submitted again gives the same job, whichever files
/// are beside it.
std::string request_id_of(const CaseUnderCheck& checked, const std::string& given) {
  const std::string name = std::filesystem::path(checked.read.source.file()).filename();
  return values::uuid_of(given + '\n' + name + '\n' + values::sha256(checked.text));
}

/// The request ids of all cases. A file that is named twice is meant twice, unless the user gave an
/// id.
std::vector<std::string> request_ids_of(const std::vector<CaseUnderCheck>& cases,
                                        SubmitOptions& options) {
  const bool given = !options.request_id.empty();
  if (!given) options.request_id = values::random_uuid();

  std::vector<std::string> ids;
  for (const CaseUnderCheck& checked : cases) {
    const std::string id = request_id_of(checked, options.request_id);
    const bool is_new = std::ranges::find(ids, id) == ids.end();
    ids.push_back(is_new || given ? id : values::random_uuid());
  }
  return ids;
}

v1::SubmitJobRequest request_of(const CaseUnderCheck& checked, const std::string& request_id,
                                const SubmitOptions& options, Connection& connection) {
  v1::SubmitJobRequest request = submission_of(checked, connection);
  request.set_request_id(request_id);
  request.set_after_end(static_cast<v1::AwaitedEnd>(options.after_end));
  if (!options.begin.empty())
    request.mutable_begin_time()->set_seconds(seconds_to_come(options.begin));
  request.mutable_after()->Assign(options.after.begin(), options.after.end());
  request.set_priority(static_cast<v1::Priority>(options.priority));
  request.mutable_labels()->Assign(options.labels.begin(), options.labels.end());
  if (!options.time_limit.empty())
    request.set_time_limit_s(case_file::parse_quantity(options.time_limit, "s").value.value());
  request.set_mail(options.mail);
  return request;
}

grpc::Status submitted(Connection& connection, const v1::SubmitJobRequest& request,
                       const std::string& given_id, v1::Job& job) try {
  return connection.try_call(&Stub::SubmitJob, request, job);
} catch (const Interrupted&) {
  throw Interrupted(
      "jobs may be in the queue already (dccast list). The same command with --request-id " +
      given_id + " makes none of them twice");
}

/// @return empty if the server has found further faults, which have been printed
std::optional<v1::Job> submit(CaseUnderCheck& checked, const std::string& request_id,
                              const SubmitOptions& options, Connection& connection) {
  const v1::SubmitJobRequest request = request_of(checked, request_id, options, connection);
  v1::Job job;
  const grpc::Status status = submitted(connection, request, options.request_id, job);
  checked.faults = faults_of(status);
  if (!checked.faults.empty()) {
    refuse_submission(checked, options.json);
    return std::nullopt;
  }
  check(status, connection.server());
  std::cout << (options.json ? to_json(job).dump() : job.id()) << std::endl;
  return job;
}

ExitCode run(const SubmitOptions& given, Program& program) {
  require_source(given);
  SubmitOptions options = given;
  Connection connection = program.connect();
  options.after = resolve_jobs(connection, options.after);
  auto cases = examined_cases(options, connection);
  if (!cases) return ExitCode::invalid;
  const std::vector<std::string> request_ids = request_ids_of(*cases, options);
  std::vector<std::string> ids;
  for (std::size_t i = 0; i < cases->size(); ++i) {
    const auto job = submit((*cases)[i], request_ids[i], options, connection);
    if (!job) return ExitCode::invalid;
    if (options.watch)
      return watch_job(connection, job->id(), 1, options.json, true, options.strict);
    ids.push_back(job->id());
  }
  if (options.notify.empty()) return ExitCode::done;
  return wait_for_jobs(connection, ids, options.notify, options.json);
}

constexpr const char* submit_examples =
    R"(dccast submit my.toml
  dccast submit --watch --priority high my.toml
  dccast submit --set mesh.rows=30 --set schedule.water_flow.scale="0.8 until 100 mm" my.toml
  dccast submit --label trial-7 --request-id trial-7 casts/*.toml
  dccast submit --from JOB --set mesh.rows=30
  dccast submit --after JOB next.toml
  dccast submit --after JOB --after-end failure retry.toml
  dccast submit --begin 22:00 casts/*.toml
  sed s/680/690/ my.toml | dccast submit -

Of several files all are checked before the first is submitted; one id a line.)";

struct WatchOptions {
  std::string id;
  std::int64_t from = 1;
  bool json = false;
  bool strict = false;
};

ExitCode run(const WatchOptions& options, Program& program) {
  Connection connection = program.connect();
  return watch_job(connection, resolve_job(connection, options.id), options.from, options.json,
                   false, options.strict);
}

void print_curl(const figures::RunHistory& history) {
  const std::vector<std::string> monitors = history.monitors();
  if (monitors.empty()) return;
  std::vector<std::string> headings{"monitor", ">curl mm", ">x mm"};
  // A quarter slab moves in two horizontal directions, a section in one.
  if (history.series(monitors.front()).horizontal_m.back().size() == 2) headings.push_back(">y mm");
  Table table(headings);
  for (const std::string& monitor : monitors) {
    const figures::MonitorSeries series = history.series(monitor);
    std::vector<std::string> row{series.name, fixed(1e3 * series.curl_m.back(), 3)};
    for (const double u : series.horizontal_m.back()) row.push_back(fixed(1e3 * u, 3));
    row.resize(headings.size());
    table.add(std::move(row));
  }
  const v1::StepReport& last = history.steps.back();
  std::cout << "at " << fixed(last.time_s(), 2) << " s, cast length " << mm(last.cast_length_m())
            << " mm" << (last.beyond_validity() ? ", beyond validity" : "") << '\n'
            << table.text() << std::flush;
}

v1::JobEvent::StateChange watch_for_scripts(Connection& connection, const std::string& id,
                                            std::int64_t from, const RetryPolicy& policy) {
  WatchOutput output;
  return follow_job(
      connection, id, from,
      [&](const v1::JobEvent& event) { std::cout << output.line(event).dump() << std::endl; },
      std::cerr, policy);
}

/// @param run_s  expected duration of the whole run [s]; 0 if unknown
v1::JobEvent::StateChange watch_for_people(Connection& connection, const std::string& id,
                                           std::int64_t from, bool messages_only, double run_s,
                                           const RetryPolicy& policy) {
  Progress progress(messages_only ? std::cerr : std::cout, terminal_of(messages_only ? 2 : 1));
  progress.expect(run_s);
  const auto end = follow_job(
      connection, id, from, [&](const v1::JobEvent& event) { progress.show(event); }, std::cerr,
      policy);
  progress.finish();
  print_curl(progress.history());
  return end;
}

/// The present job, or an empty one: the watch reports errors.
v1::Job job_now(Connection& connection, const std::string& id) {
  v1::GetJobRequest request;
  request.set_id(id);
  v1::Job job;
  try {
    connection.try_once(&Stub::GetJob, request, job);
  } catch (const Interrupted&) {
    return {};  // the watch itself reports how to continue
  }
  return job;
}

/// Expected duration of the whole run by the server's estimate [s]; 0 if unknown.
double expected_run_s(const v1::Job& job) {
  if (!job.has_ends_in_s()) return job.estimated_s();
  return job.ends_in_s() - job.starts_in_s() + job.last_step().solver_s();
}

}  // namespace

void add_submit(CommandLine& line, Program& program) {
  const auto [command, options] = declare<SubmitOptions>(
      line, program, run, "submit", "Queue cases; prints the id of each job", submit_examples);

  command.option("FILE", options.files, "Case files; - for standard input");
  command.option("--from", options.from, "Instead of a FILE: the case of this job, as submitted",
                 {.placeholder = "JOB"});
  command.repeatable("--after", options.after,
                     "Start when these jobs have succeeded; cancelled if one does not; repeatable",
                     {.comma_separated = true, .placeholder = "JOB"});
  command.choice("--after-end", options.after_end,
                 {{"success", v1::AWAITED_SUCCESS},
                  {"failure", v1::AWAITED_FAILURE},
                  {"any", v1::AWAITED_ANY_END}},
                 "How the jobs of --after must end: success (default), failure or any",
                 {.placeholder = "END", .needs = "--after"});
  command.option("--begin", options.begin,
                 "Start not before this time: 22:00, \"3 h\", tomorrow, \"2026-11-20 08:15\"",
                 {.placeholder = "TIME"});

  add_set_option(command, options.set);
  command.repeatable("--label", options.labels, "Label for finding the job; repeatable",
                     {.comma_separated = true});
  command.flag("-w,--watch", options.watch,
               "Follow the job to its end; exit code 3 if it does not succeed");
  command.flag("--strict", options.strict,
               "With --watch: exit code 3 for a job with findings beyond notes too",
               {.needs = "--watch"});

  command.choice("-p,--priority", options.priority, priorities(),
                 "Place in the queue: low, normal (default) or high", {.placeholder = "PRIORITY"});
  command.option("--time-limit", options.time_limit,
                 "Wall time after which the job ends as failed, e.g. \"30 min\"",
                 {.fault = [](const std::string& text) {
                   return case_file::parse_quantity(text, "s").message;
                 }});

  command.option("--mail", options.mail,
                 "Address passed to the server's hook at the end of the job",
                 {.placeholder = "ADDRESS"});
  command.option("--notify", options.notify,
                 "Wait for the jobs, and run this for each as wait --notify does",
                 {.placeholder = "COMMAND", .excludes = {"--watch"}});

  command.option(
      "--request-id", options.request_id,
      "A file submitted again under this id, with name and content as before, gives the same job; "
      "by default each gives a new one",
      {.fault = [](const std::string& text) { return values::too_long("the request id", text); }});
  command.json(options.json,
               "Print each job as a line of JSON, with --watch followed by a line for each event");
}

ExitCode watch_job(Connection& connection, const std::string& id, std::int64_t from, bool json,
                   bool messages_only, bool strict, const RetryPolicy& policy) {
  const v1::Job job = job_now(connection, id);
  if (!job.held().empty()) std::cerr << "held: " << job.held() << std::endl;
  const auto end =
      json ? watch_for_scripts(connection, id, from, policy)
           : watch_for_people(connection, id, from, messages_only, expected_run_s(job), policy);
  if (end.has_failure())
    std::cerr << "dccast: job " << id << ": " << failure_text(end.failure()) << '\n';
  const ExitCode code = exit_code_of(end.state());
  if (!strict || code != ExitCode::done) return code;
  // Counts all findings of the job: a watch may start after some of them.
  if (!more_than_notes(connection.call(&Stub::GetJob, id).findings())) return code;
  std::cerr << "dccast: job " << id << " has findings beyond notes (--strict)\n";
  return ExitCode::solve_failed;
}

void add_watch(CommandLine& line, Program& program) {
  const auto [command, options] = declare<WatchOptions>(
      line, program, run, "watch",
      "Follow a job to its end: every event so far, then as they happen. A dropped connection is "
      "restored; Ctrl-C does not affect the job",
      "dccast watch JOB\n  dccast watch --json --from 120 JOB | jq .time_s");
  command.option("JOB", options.id, job_help, required);
  command.option("--from", options.from, "Sequence number of the first event", {.positive = true});
  command.flag("--strict", options.strict,
               "Exit code 3 also for a job with findings beyond notes (docs/findings.md)");
  command.json(options.json, "One JSON object per event and line");
}

}  // namespace dccast::client
