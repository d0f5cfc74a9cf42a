#include <iostream>

#include "client/commands/commands.hpp"
#include "client/job_id.hpp"
#include "client/job_watch.hpp"
#include "client/render/findings.hpp"
#include "client/render/job_text.hpp"
#include "client/render/progress.hpp"
#include "client/render/table.hpp"
#include "client/render/watch_output.hpp"

namespace dccast::client::commands {
namespace {

struct Options {
  std::string id;
  std::int64_t from = 1;
  bool json = false;
  bool strict = false;
};

void print_curl(const render::CurlHistory& history) {
  if (history.monitors.empty()) return;
  render::Table table({"monitor", ">curl mm", ">horizontal mm"});
  for (const auto& series : history.monitors)
    table.add({series.name, render::fixed(1e3 * series.curl_m.back(), 3),
               render::fixed(1e3 * series.horizontal_m.back(), 3)});
  std::cout << "at " << render::fixed(history.time_s.back(), 2) << " s, cast length "
            << render::fixed(1e3 * history.cast_length_m.back(), 1) << " mm"
            << (history.beyond.back() ? ", beyond validity" : "") << '\n'
            << table.text() << std::flush;
}

v1::JobEvent::StateChange watch_for_scripts(Connection& connection, const std::string& id,
                                            std::int64_t from) {
  render::WatchOutput output;
  return follow_job(
      connection, id, from,
      [&](const v1::JobEvent& event) { std::cout << output.line(event).dump() << std::endl; },
      std::cerr);
}

v1::JobEvent::StateChange watch_for_people(Connection& connection, const std::string& id,
                                           std::int64_t from, bool talk_only) {
  render::Progress progress(talk_only ? std::cerr : std::cout,
                            render::terminal_of(talk_only ? 2 : 1));
  const auto end = follow_job(
      connection, id, from, [&](const v1::JobEvent& event) { progress.show(event); }, std::cerr);
  progress.finish();
  print_curl(progress.history());
  return end;
}

/// Reports why a job waits, if it is held; errors are left to the watch.
void say_if_held(Connection& connection, const std::string& id) {
  v1::GetJobRequest request;
  request.set_id(id);
  v1::Job job;
  connection.set_policy({.attempts = 1});  // the watch itself retries
  try {
    connection.try_call(&Stub::GetJob, request, job);
  } catch (const Interrupted&) {
    return;  // the watch itself reports how to continue
  }
  if (!job.held().empty()) std::cerr << "held: " << job.held() << std::endl;
}

/// Findings of the whole job: a watch may start after some of them.
bool is_implausible(Connection& connection, const std::string& id) {
  v1::GetJobRequest request;
  request.set_id(id);
  return render::more_than_notes(connection.call(&Stub::GetJob, request).findings());
}

}  // namespace

ExitCode watch_job(Connection& connection, const std::string& id, std::int64_t from, bool json,
                   bool talk_only, bool strict) {
  say_if_held(connection, id);
  const auto end = json ? watch_for_scripts(connection, id, from)
                        : watch_for_people(connection, id, from, talk_only);
  if (end.has_failure())
    std::cerr << "dccast: job " << id << ": " << render::failure_text(end.failure()) << '\n';
  const ExitCode code = exit_code_of(end.state());
  if (!strict || code != ExitCode::done || !is_implausible(connection, id)) return code;
  std::cerr << "dccast: job " << id << " has findings beyond notes (--strict)\n";
  return ExitCode::solve_failed;
}

void add_watch(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command =
      subcommand(app, "watch",
                 "Follow a job to its end: every event so far, then as they happen. A dropped "
                 "connection is taken up again; leaving with Ctrl-C does not touch the job",
                 "dccast watch JOB\n  dccast watch --json --from 120 JOB | jq .time_s");
  command->add_option("JOB", options->id, job_help)->required();
  command->add_option("--from", options->from, "Sequence number of the first event")
      ->check(CLI::PositiveNumber);
  command->add_flag("--strict", options->strict,
                    "Exit code 3 for a job with findings beyond notes too (docs/findings.md)");
  command->add_flag("--json", options->json, "One JSON object per event and line");
  command->callback([options, &program] {
    program.action = [options, &program] {
      Connection connection = program.connect();
      return watch_job(connection, resolve_job(connection, options->id), options->from,
                       options->json, false, options->strict);
    };
  });
}

}  // namespace dccast::client::commands
