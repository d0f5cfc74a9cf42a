#include <algorithm>
#include <charconv>
#include <chrono>
#include <iostream>
#include <map>
#include <string_view>

#include "client/cli/common_options.hpp"
#include "client/commands/commands.hpp"
#include "client/model/answer.hpp"
#include "client/model/json.hpp"
#include "client/session/case_faults.hpp"
#include "client/session/studies.hpp"
#include "client/text/findings.hpp"
#include "client/text/job_text.hpp"
#include "client/text/progress.hpp"
#include "client/text/study_text.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/values/digests.hpp"

namespace dccast::client::commands {
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

/// The refinement in "refinement 4: the case has ..."; 0 where a message begins otherwise.
int refused_refinement(const std::string& message) {
  constexpr std::string_view word = "refinement ";
  int refinement = 0;
  if (message.starts_with(word))
    std::from_chars(message.data() + word.size(), message.data() + message.size(), refinement);
  return refinement;
}

/// Reports why the server rejects a study of this case.
void print_refusal(const CaseUnderCheck& checked, const grpc::Status& status) {
  const int refinement = refused_refinement(status.error_message());
  const auto& mesh = checked.description.mesh();
  const int base = mesh.has_refinement() ? mesh.refinement() : 1;
  const bool finer = refinement > base;
  for (const v1::Fault& fault : faults_of(status))
    std::cerr << (finer ? "refinement " + std::to_string(refinement) + ": " : "")
              << describe(fault, checked.read.source) << '\n';
  if (!finer) return;
  std::cerr << "dccast: nothing submitted, refinement " << refinement << " would be refused";
  int levels = 0;
  for (int coarser = base; coarser < refinement; coarser *= 2) ++levels;
  if (levels >= 2) std::cerr << "; the coarser ones go with --levels " << levels;
  std::cerr << '\n';
}

grpc::Status create(const Options& options, const std::string& study, const CaseUnderCheck& checked,
                    Connection& connection) {
  v1::CreateStudyRequest request;
  request.set_request_id(study);
  *request.mutable_case_() = checked.description;
  *request.mutable_attachments() = {checked.read.attachments.begin(),
                                    checked.read.attachments.end()};
  *request.mutable_changes() = {checked.changes.begin(), checked.changes.end()};
  request.mutable_refinement()->set_levels(options.levels);
  v1::Study created;
  try {
    return connection.try_call(&Stub::CreateStudy, request, created);
  } catch (const Interrupted&) {
    throw Interrupted("the study may be on the server. Come back: " + way_back(options, study));
  }
}

/// Reports the estimated cost of all levels before any of them starts.
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
  std::cerr << options.levels << " runs, roughly " << render::duration_text(solver_s)
            << " of computing\n";
}

/// Creates the study, or adds its missing levels. @return whether the server has it
bool submit(const Options& options, const std::string& study, Connection& connection) {
  CaseUnderCheck checked = read_case(options.file, changes_of(options.set));
  check_with_server(checked, connection);
  print_faults(checked, std::cerr);
  if (!checked.faults.empty()) return false;
  print_effort(checked, options, connection);
  const grpc::Status status = create(options, study, checked, connection);
  if (status.error_code() == grpc::StatusCode::ALREADY_EXISTS)
    throw CommandFailed(ExitCode::invalid,
                        "study " + study + " is of another case" +
                            ". Take it up without FILE, or begin a new one without --study");
  if (!faults_of(status).empty()) {
    print_refusal(checked, status);
    return false;
  }
  check(status, connection.server());
  return true;
}

/// Lets the server queue lost levels again.
void repair(Connection& connection, const std::string& study) {
  v1::ResumeStudyRequest request;
  request.set_id(study);
  v1::Study resumed;
  const grpc::Status status = connection.try_call(&Stub::ResumeStudy, request, resumed);
  if (status.error_code() == grpc::StatusCode::NOT_FOUND)
    throw CommandFailed(ExitCode::not_found, "no job belongs to study " + study + " here");
  check(status, connection.server());
}

/// Prints the job of each level as soon as it has one.
class LevelNames {
public:
  /// @param before  the study as it was before levels were queued again
  explicit LevelNames(const v1::StudyResult& before) {
    for (const v1::StudyRun& run : before.runs()) known_[run.refinement()] = run;
  }

  void name(const v1::StudyResult& now) {
    for (const v1::StudyRun& run : now.runs()) {
      v1::StudyRun& known = known_[run.refinement()];
      if (run.job().empty() || run.job() == known.job()) continue;
      std::cerr << "refinement " << run.refinement() << ": job " << run.job();
      if (!known.job().empty())
        std::cerr << " replaces job " << known.job() << ", which is "
                  << render::state_text(known.state());
      std::cerr << std::endl;
      known = run;
    }
  }

private:
  std::map<int, v1::StudyRun> known_;
};

/// The present state of the study; empty if there is none yet.
v1::StudyResult as_it_is(Connection& connection, const std::string& id) {
  v1::EvaluateStudyRequest request;
  request.set_id(id);
  v1::StudyResult result;
  const grpc::Status status = connection.try_call(&Stub::EvaluateStudy, request, result);
  if (status.error_code() == grpc::StatusCode::NOT_FOUND) return {};
  check(status, connection.server());
  return result;
}

void print_paused_jobs(Connection& connection, const std::string& id) {
  for (const v1::Job& job : jobs_of_study(connection, id))
    if (job.state() == v1::PAUSED)
      std::cerr << "waiting for job " << job.id() << ", which is paused: dccast resume " << job.id()
                << '\n';
}

bool waits_for_its_job(const v1::StudyRun& run) {
  return run.job().empty() && run.state() == v1::QUEUED;
}

/// Prints the jobs of all levels; the server queues them shortly, unless its disk is full.
void name_jobs(Connection& connection, const std::string& id, LevelNames& names) {
  constexpr std::chrono::milliseconds pause{50};
  constexpr int most_attempts = 100;
  for (int made = 0; made < most_attempts; ++made) {
    const v1::StudyResult now = evaluate_study(connection, id);
    names.name(now);
    if (std::none_of(now.runs().begin(), now.runs().end(), waits_for_its_job)) return;
    connection.interruption().sleep(pause);
  }
}

/// Waits until every job of the study has ended. Throws Interrupted with the command that
/// continues.
Study finished_study(Connection& connection, const std::string& id, LevelNames& names) {
  try {
    name_jobs(connection, id, names);
    print_paused_jobs(connection, id);
    follow_study(
        connection, id, [](const v1::Study&) {}, std::cerr);
    return read_study(connection, id);
  } catch (const Interrupted&) {
    throw Interrupted("the jobs go on. Come back: dccast convergence --study " + id);
  }
}

/// Reports missing levels and the reason. @return whether every level succeeded
bool report_losses(const Study& study) {
  bool whole = true;
  for (const v1::Job& job : study.others)
    std::cerr << "job " << job.id() << " is left out: another job stands for its level\n";
  for (const StudyLevel& level : study.levels) {
    if (level.job.has_validity_loss())
      std::cerr << "dccast: refinement " << level.refinement << " (job " << level.job.id()
                << ") is " << render::validity_text(level.job.validity_loss()) << '\n';
    if (level.succeeded()) continue;
    whole = false;
    std::cerr << "dccast: refinement " << level.refinement << " (job " << level.job.id() << ") is "
              << render::state_text(level.job.state());
    if (level.job.has_failure()) std::cerr << ": " << render::failure_text(level.job.failure());
    std::cerr << '\n';
  }
  return whole;
}

Json monitor_json(const Study& study, const MonitorStudy& monitor) {
  const CurveLimit& limit = monitor.limit;
  const std::size_t worst = monitor.least_certain();
  return {{"name", monitor.name},
          {"curl_m", monitor.end_curl_m},
          {"order", limit.order ? Json(*limit.order) : Json(nullptr)},
          {"limit_m", limit.value_m.back()},
          {"uncertainty_m", limit.uncertainty_m.back()},
          {"largest_uncertainty_m", limit.uncertainty_m[worst]},
          {"largest_uncertainty_time_s", study.time_s[worst]},
          {"history", {{"limit_m", limit.value_m}, {"uncertainty_m", limit.uncertainty_m}}}};
}

Json validity_json(const v1::Job& job) {
  return job.has_validity_loss() ? to_json(job.validity_loss()) : Json();
}

void print_json(const Study& study) {
  Json json{{"study", study.id}, {"levels", Json::array()}};
  for (const StudyLevel& level : study.levels)
    json["levels"].push_back({{"refinement", level.refinement},
                              {"job", level.job.id()},
                              {"state", v1::JobState_Name(level.job.state())},
                              {"nodes", level.job.last_step().nodes()},
                              {"solver_s", level.job.last_step().solver_s()},
                              {"validity_loss", validity_json(level.job)}});
  json["time_s"] = study.time_s;
  json["cast_length_m"] = study.cast_length_m;
  json["beyond_validity"] = Json::array();
  for (const double instant_s : study.time_s)
    json["beyond_validity"].push_back(!study.valid_at(instant_s));
  json["monitors"] = Json::array();
  for (const MonitorStudy& monitor : study.monitors)
    json["monitors"].push_back(monitor_json(study, monitor));
  std::cout << json.dump() << '\n';
}

ExitCode run(const Options& options, Program& program) {
  if (options.file.empty() && options.study.empty())
    throw CommandFailed(ExitCode::invalid,
                        "give a case FILE to begin a study, or --study ID to take one up again");
  Connection connection = program.connect();
  const std::string id =
      options.study.empty() ? values::random_uuid() : resolve_study(connection, options.study);
  LevelNames names(options.study.empty() ? v1::StudyResult{} : as_it_is(connection, id));
  if (!options.file.empty()) {
    std::cerr << "study " << id << "; taken up again by dccast convergence --study " << id << '\n';
    if (!submit(options, id, connection)) return ExitCode::invalid;
  }
  if (!options.as_it_is && !options.study.empty()) repair(connection, id);
  const Study study = finished_study(connection, id, names);
  if (options.json)
    print_json(study);
  else
    std::cout << "study " << study.id << '\n' << render::study_table(study);
  std::cout << std::flush;
  return report_losses(study) ? ExitCode::done : ExitCode::solve_failed;
}

constexpr const char* examples =
    "dccast convergence my.toml\n"
    "  dccast convergence --levels 2 --json my.toml\n"
    "  dccast convergence --study ID                     take it up again, after an interruption "
    "or later\n"
    "  dccast convergence --study ID --as-it-is          only show it\n"
    "  dccast convergence --study ID --levels 4 my.toml  add what is missing, here a finer level\n"
    "\n"
    "Rows below the levels: observed order of the whole history, the limit at the end and its\n"
    "uncertainty, and where in the history that is largest. A level that was cancelled, or lost "
    "to\n"
    "its worker or a full disk, is submitted again by --study; one that failed by its own case is\n"
    "left out, and the exit code is then 3. The jobs have one study id; `dccast report JOB` of "
    "each draws the band.";

}  // namespace

void add_convergence(cli::CommandLine& line, Program& program) {
  const auto options = std::make_shared<Options>();
  const cli::Command command = line.command(
      "convergence",
      "How much of a curl is discretisation: runs the case with cells and steps halved again and "
      "again, and extrapolates the curl of every monitor",
      examples);
  command.option("FILE", options->file, "Case file; needed to begin a study");
  add_set_option(command, options->set);
  command.option(
      "--study", options->study,
      "Take this study up again: submit levels that were lost again, wait for what has not ended, "
      "print the table; with FILE also submit the levels that are missing");
  command.flag("--as-it-is", options->as_it_is,
               "With --study and without FILE: submit nothing, levels that were lost stay so");
  command
      .option("--levels", options->levels,
              "Runs, each with half the cell and step of the one before; an order needs three")
      .between(2, 5)
      .show_default();
  command.json(options->json, "As JSON, in metres and seconds, with the histories");
  command.action([options, &program] { return run(*options, program); });
}

}  // namespace dccast::client::commands
