#include <iostream>

#include "client/case_faults.hpp"
#include "client/case_options.hpp"
#include "client/commands/commands.hpp"
#include "client/divided_case.hpp"
#include "client/job_watch.hpp"
#include "client/message_json.hpp"
#include "client/render/job_text.hpp"
#include "client/render/study_table.hpp"
#include "client/render/validity.hpp"
#include "client/study_reading.hpp"
#include "client/study_submission.hpp"
#include "proto/values/uuid.hpp"

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

/// Submits what of the study is not there yet. @return whether it is all there
bool submit(const Options& options, const std::string& study, Connection& connection) {
  CaseUnderCheck checked = read_case(options.file, changes_of(options.set));
  if (!checked.faults.empty()) {
    check_with_server(checked, connection);
    print_faults(checked, std::cerr);
    return false;
  }
  if (const std::string reason = reason_against_dividing(checked.description); !reason.empty())
    throw CommandFailed(ExitCode::invalid, reason);
  return submit_study(connection, checked, study, options.levels);
}

/// Replaces levels that were lost. Throws Interrupted with the command to come back by.
void repair(Connection& connection, const std::string& study) {
  try {
    repair_study(connection, study);
  } catch (const Interrupted&) {
    throw Interrupted("Come back: dccast convergence --study " + study);
  }
}

void wait_for_all(Connection& connection, const std::string& study) {
  const std::vector<v1::Job> jobs = jobs_of_study(connection, study);
  if (jobs.empty())
    throw CommandFailed(ExitCode::not_found, "no job belongs to study " + study + " here");
  for (const v1::Job& job : jobs) {
    if (job.has_end_time()) continue;
    if (job.state() == v1::PAUSED)
      std::cerr << "waiting for job " << job.id() << ", which is paused: dccast resume " << job.id()
                << '\n';
    follow_job(
        connection, job.id(), 1, [](const v1::JobEvent&) {}, std::cerr);
  }
}

/// The study with every job ended. Throws Interrupted with the command to come back by.
Study finished_study(Connection& connection, const std::string& id) {
  try {
    wait_for_all(connection, id);
    return read_study(connection, id);
  } catch (const Interrupted&) {
    throw Interrupted("the jobs go on. Come back: dccast convergence --study " + id);
  }
}

/// Says what is missing, and why. @return whether every level succeeded
bool report_losses(const Study& study) {
  bool whole = true;
  for (const v1::Job& job : study.others)
    std::cerr << "job " << job.id()
              << " is left out: another case, or a refinement that another job stands for\n";
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
  const std::string id = options.study.empty() ? values::random_uuid() : options.study;
  if (!options.file.empty()) {
    std::cerr << "study " << id << "; taken up again by dccast convergence --study " << id << '\n';
    if (!submit(options, id, connection)) return ExitCode::invalid;
  } else if (!options.as_it_is) {
    repair(connection, id);
  }
  const Study study = finished_study(connection, id);
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

void add_convergence(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command = subcommand(
      app, "convergence",
      "How much of a curl is discretisation: runs the case with cells and steps halved again and "
      "again, and extrapolates the curl of every monitor",
      examples);
  command->add_option("FILE", options->file, "Case file; needed to begin a study");
  add_set_option(*command, options->set);
  command->add_option(
      "--study", options->study,
      "Take this study up again: submit levels that were lost again, wait for what has not ended, "
      "print the table; with FILE also submit the levels that are missing");
  command->add_flag("--as-it-is", options->as_it_is,
                    "With --study and without FILE: submit nothing, levels that were lost stay so");
  command
      ->add_option("--levels", options->levels,
                   "Runs, each with half the cell and step of the one before; an order needs three")
      ->check(CLI::Range(2, 5))
      ->capture_default_str();
  command->add_flag("--json", options->json, "As JSON, in metres and seconds, with the histories");
  command->callback([options, &program] {
    program.action = [options, &program] { return run(*options, program); };
  });
}

}  // namespace dccast::client::commands
