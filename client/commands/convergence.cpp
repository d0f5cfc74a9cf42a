#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <iostream>
#include <map>

#include "client/cli/common_options.hpp"
#include "client/commands/commands.hpp"
#include "client/model/answer.hpp"
#include "client/session/case_faults.hpp"
#include "client/session/studies.hpp"
#include "client/text/findings.hpp"
#include "client/text/job_text.hpp"
#include "client/text/progress.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/values/digests.hpp"

namespace dccast::client {
namespace {

struct Options {
  std::string file;
  std::vector<std::string> set;
  std::string study;
  int levels = 3;
  bool as_it_is = false;
  bool json = false;
};

std::string way_back(const Options& options, const std::string& study) {
  std::string command = "dccast convergence --study " + study;
  if (!options.file.empty())
    command += " --levels " + std::to_string(options.levels) + " " + options.file;
  return command;
}

/// Prints why the server rejects a study of this case.
void print_refusal(const CaseUnderCheck& checked, const v1::ValidateCaseResponse& verdict) {
  const int refinement = verdict.refinement();
  const auto& mesh = checked.description.mesh();
  const int base = mesh.has_refinement() ? mesh.refinement() : 1;
  const bool finer = refinement > base;
  for (const v1::Fault& fault : verdict.faults())
    std::cerr << (finer ? "refinement " + std::to_string(refinement) + ": " : "")
              << describe(fault, checked.read.source) << '\n';
  if (!finer) return;
  std::cerr << "dccast: nothing submitted, refinement " << refinement << " would be refused";
  // The finest level is refused first: how many coarser ones would be accepted?
  int levels = 0;
  for (int coarser = base; coarser < refinement; coarser *= 2) ++levels;
  if (levels >= 2) std::cerr << "; the coarser ones go with --levels " << levels;
  std::cerr << '\n';
}

grpc::Status create(const Options& options, const std::string& study, const CaseUnderCheck& checked,
                    Connection& connection) {
  v1::CreateStudyRequest request;
  request.set_request_id(study);
  put_case(checked, connection, request);
  request.mutable_refinement()->set_levels(options.levels);
  v1::Study created;
  try {
    return connection.try_call(&Stub::CreateStudy, request, created);
  } catch (const Interrupted&) {
    throw Interrupted("the study may be on the server. Come back: " + way_back(options, study));
  }
}

/// Prints the estimated cost of all levels before the first one starts.
void print_effort(CaseUnderCheck level, const Options& options, Connection& connection) {
  if (!level.estimate || !case_file::reason_against_dividing(level.description).empty()) return;
  double solver_s = level.estimate->solver_s();
  const v1::Case coarsest = level.description;
  for (int number = 1; number < options.levels; ++number) {
    level.description = case_file::divided(coarsest, 1 << number);
    level.estimate.reset();
    check_with_server(level, connection);
    if (!level.estimate) return;  // CreateStudy reports why it is rejected
    solver_s += level.estimate->solver_s();
  }
  std::cerr << options.levels << " runs, roughly " << duration_text(solver_s) << " of computing\n";
}

/// Creates the study or adds its missing levels. @return whether the server has it
bool submit(const Options& options, const std::string& study, Connection& connection) {
  CaseUnderCheck checked = read_case(options.file, changes_of(options.set));
  check_with_server(checked, connection);
  print_faults(checked, std::cerr);
  if (!checked.faults.empty()) return false;
  print_effort(checked, options, connection);
  const grpc::Status status = create(options, study, checked, connection);
  if (status.error_code() == grpc::StatusCode::ALREADY_EXISTS)
    throw invalid("study " + study + " is of another case" +
                  ". Take it up without FILE, or begin a new one without --study");
  const v1::ValidateCaseResponse verdict = verdict_of(status);
  if (!verdict.faults().empty()) {
    print_refusal(checked, verdict);
    return false;
  }
  check(status, connection.server());
  return true;
}

/// Queues lost levels again.
void repair(Connection& connection, const std::string& study) {
  v1::ResumeStudyRequest request;
  request.set_id(study);
  v1::Study resumed;
  const grpc::Status status = connection.try_call(&Stub::ResumeStudy, request, resumed);
  if (status.error_code() == grpc::StatusCode::NOT_FOUND)
    throw CommandFailed(ExitCode::not_found, "no job belongs to study " + study + " here");
  check(status, connection.server());
}

/// Levels by their refinement, as reported last.
using NamedLevels = std::map<int, v1::StudyRun>;

/// Prints the job of each level as soon as it has one.
void name_levels(const v1::StudyResult& now, NamedLevels& named) {
  for (const v1::StudyRun& run : now.runs()) {
    v1::StudyRun& known = named[run.refinement()];
    if (run.job().empty() || run.job() == known.job()) continue;
    std::cerr << "refinement " << run.refinement() << ": job " << run.job();
    if (!known.job().empty())
      std::cerr << " replaces job " << known.job() << ", which is " << state_text(known.state());
    std::cerr << std::endl;
    known = run;
  }
}

void print_paused_jobs(Connection& connection, const std::string& id) {
  for (const v1::Job& job : jobs_of_study(connection, id))
    if (job.state() == v1::PAUSED)
      std::cerr << "waiting for job " << job.id() << ", which is paused: dccast resume " << job.id()
                << '\n';
}

/// Prints the jobs of all levels. The server queues them shortly, unless its disk is full.
void name_jobs(Connection& connection, const std::string& id, NamedLevels& levels) {
  constexpr std::chrono::milliseconds pause{50};
  constexpr int most_attempts = 100;
  for (int made = 0; made < most_attempts; ++made) {
    const v1::StudyResult now = evaluate_study(connection, id);
    name_levels(now, levels);
    const bool waiting = std::ranges::any_of(now.runs(), [](const v1::StudyRun& run) {
      return run.job().empty() && run.state() == v1::QUEUED;
    });
    if (!waiting) return;
    connection.interruption().sleep(pause);
  }
}

/// Waits until every job of the study has ended. Throws CommandFailed, also for a study of another
/// kind, and Interrupted with the command that continues.
v1::StudyJudgement judged_after_its_end(Connection& connection, const std::string& id,
                                        NamedLevels& levels) {
  try {
    name_jobs(connection, id, levels);
    print_paused_jobs(connection, id);
    follow_study(
        connection, id, [](const v1::Study&) {}, std::cerr);
  } catch (const Interrupted&) {
    throw Interrupted("the jobs go on. Come back: dccast convergence --study " + id);
  }

  // Any study can be named by its id; the others have no order of convergence.
  v1::StudyJudgement answer = judge_study(connection, {.id = id});
  if (!answer.study().has_refinement())
    throw invalid("study " + id + " compares no meshes; dccast studies " + id +
                  " shows what it is");
  return answer;
}

/// Prints missing levels with the reason. @return whether every level succeeded
bool report_losses(const v1::StudyResult& result) {
  bool whole = true;
  for (const v1::StudyRun& run : result.runs()) {
    const std::string level =
        fmt::format("dccast: refinement {} (job {}) is ", run.refinement(), run.job());
    if (run.beyond_validity()) std::cerr << level << beyond_validity << '\n';
    // A run beyond validity has figures all the same; only one that failed is missing.
    if (run.state() == v1::SUCCEEDED) continue;

    whole = false;
    std::cerr << level << state_text(run.state());
    if (run.has_failure()) std::cerr << ": " << failure_text(run.failure());
    std::cerr << '\n';
  }
  return whole;
}

ExitCode run(const Options& options, Program& program) {
  if (options.file.empty() && options.study.empty())
    throw invalid("give a case FILE to begin a study, or --study ID to take one up again");

  Connection connection = program.connect();
  const std::string id =
      options.study.empty() ? values::random_uuid() : resolve_study(connection, options.study);

  NamedLevels levels;
  if (!options.study.empty()) {
    const v1::StudyResult before = find_study(connection, id);
    for (const v1::StudyRun& run : before.runs()) levels[run.refinement()] = run;
  }
  if (!options.file.empty()) {
    std::cerr << "study " << id << "; taken up again by dccast convergence --study " << id << '\n';
    if (!submit(options, id, connection)) return ExitCode::invalid;
  }
  // Levels that were lost are submitted again, unless only a look is wanted.
  if (!options.as_it_is && !options.study.empty()) repair(connection, id);

  const v1::StudyJudgement answer = judged_after_its_end(connection, id, levels);
  StudyOptions shown;
  shown.json = options.json;
  print_answer(shown, answer);
  return report_losses(answer.result()) ? ExitCode::done : ExitCode::solve_failed;
}

constexpr const char* convergence_examples =
    "dccast convergence my.toml\n"
    "  dccast convergence --levels 2 --json my.toml\n"
    "  dccast convergence --study ID                     take it up again, after an interruption "
    "or later\n"
    "  dccast convergence --study ID --as-it-is          only show it\n"
    "  dccast convergence --study ID --levels 4 my.toml  add what is missing, here a finer level\n"
    "\n"
    "Below the levels: observed order of the whole history, the limit at the end and its\n"
    "uncertainty, and where in the history that is largest. A level that was cancelled, or lost "
    "to\n"
    "its worker or a full disk, is submitted again by --study; one that failed by its own case is\n"
    "left out, and the exit code is then 3. The jobs have one study id; `dccast report JOB` of "
    "each draws the band.";

}  // namespace

void add_convergence(CommandLine& line, Program& program) {
  const auto [command, options] =
      declare<Options>(line, program, run, "convergence",
                       "How much of a curl is discretisation: runs the case with cells and steps "
                       "halved again and again, and extrapolates the curl of every monitor",
                       convergence_examples);
  command.option("FILE", options.file, "Case file; needed to begin a study");
  add_set_option(command, options.set);
  command.option("--study", options.study,
                 "Take this study up again: submit levels that were lost again, wait for what has "
                 "not ended, print the table; with FILE also submit the levels that are missing");
  command.flag("--as-it-is", options.as_it_is,
               "With --study and without FILE: submit nothing; lost levels stay lost");
  command.number("--levels", options.levels, 2, 5,
                 "Runs, each with half the cell and step of the one before; an order needs three");
  command.json(options.json, "As JSON, in metres and seconds, with the histories");
}

}  // namespace dccast::client
