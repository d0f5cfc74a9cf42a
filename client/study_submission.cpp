#include "client/study_submission.hpp"

#include <iostream>

#include "client/divided_case.hpp"
#include "client/job_result.hpp"
#include "client/level_attempts.hpp"
#include "client/render/job_text.hpp"
#include "client/render/progress.hpp"
#include "client/study_reading.hpp"
#include "client/submission.hpp"

namespace dccast::client {
namespace {

/// Cells and steps of a level are divided by this.
int parts_of(int level) {
  return 1 << level;
}

CaseUnderCheck level_of(const CaseUnderCheck& checked, int level) {
  CaseUnderCheck fine = checked;
  fine.description = divided(checked.description, parts_of(level));
  return fine;
}

bool refuse(const CaseUnderCheck& fine, int level) {
  const int refinement = fine.description.mesh().refinement();
  if (level == 0) {
    print_faults(fine, std::cerr);
    return false;
  }
  for (const v1::Fault& fault : fine.faults)
    std::cerr << "refinement " << refinement << ": " << describe(fault, fine.read.source) << '\n';
  std::cerr << "dccast: nothing submitted, refinement " << refinement << " would be refused";
  if (level >= 2) std::cerr << "; the coarser ones go with --levels " << level;
  std::cerr << '\n';
  return false;
}

bool check_levels(Connection& connection, const CaseUnderCheck& checked, int levels) {
  double solver_s = 0.0;
  for (int level = 0; level < levels; ++level) {
    CaseUnderCheck fine = level_of(checked, level);
    check_with_server(fine, connection);
    if (!fine.faults.empty()) return refuse(fine, level);
    if (level == 0)
      for (const v1::Fault& warning : fine.warnings)
        std::cerr << "warning: " << describe(warning, fine.read.source) << '\n';
    if (fine.estimate) solver_s += fine.estimate->solver_s();
  }
  std::cerr << levels << " runs, roughly " << render::duration_text(solver_s)
            << " of computing in all\n";
  return true;
}

/// A level as an attempt of its study.
v1::Job submit_attempt(Connection& connection, const v1::Case& level, const std::string& study,
                       int number) {
  v1::SubmitJobRequest request;
  request.set_request_id(attempt_request_id(study, level.mesh().refinement(), number));
  request.set_study(study);
  request.set_priority(v1::LOW);  // a study must not stand in the way of a question
  *request.mutable_case_() = level;
  v1::Job job;
  const grpc::Status status = submit_patiently(connection, request, job);
  if (status.error_code() == grpc::StatusCode::ALREADY_EXISTS)
    throw CommandFailed(ExitCode::invalid,
                        "study " + study + " has a run of another case with this refinement" +
                            ". Take it up without FILE, or begin a new one without --study");
  check(status, connection.server());
  return job;
}

/// The job of a level: the one that is there, or a new one in place of none or of one that was
/// lost.
v1::Job job_of_level(Connection& connection, const v1::Case& level, const std::string& study,
                     const LevelAttempts& attempts) {
  // Also when it is there already: the server then holds the case against the one it has.
  const bool first_is_known = attempts.by_number.empty() || attempts.by_number.contains(1);
  v1::Job job;
  if (first_is_known) job = submit_attempt(connection, level, study, 1);
  if (attempts.by_number.empty()) return job;
  if (attempts.can_be_repaired())
    return submit_attempt(connection, level, study, attempts.next_number());
  return *attempts.current();
}

/// The case of a job as it was run, with all its defaults.
v1::Case case_of(Connection& connection, const v1::Job& job) {
  return query_result(connection, job.id()).case_();
}

}  // namespace

void repair_study(Connection& connection, const std::string& study) {
  for (const auto& [refinement, attempts] : attempts_of(study, jobs_of_study(connection, study))) {
    if (!attempts.can_be_repaired()) continue;
    const v1::Job& lost = *attempts.current();
    const v1::Job job =
        submit_attempt(connection, case_of(connection, lost), study, attempts.next_number());
    std::cerr << "refinement " << refinement << ": job " << job.id() << " replaces job "
              << lost.id() << ", which is " << render::state_text(lost.state()) << '\n';
  }
}

bool submit_study(Connection& connection, const CaseUnderCheck& checked, const std::string& study,
                  int levels) {
  if (!check_levels(connection, checked, levels)) return false;
  auto attempts = attempts_of(study, jobs_of_study(connection, study));
  const std::string way_back = "dccast convergence --study " + study + " --levels " +
                               std::to_string(levels) + " " + checked.read.source.file();
  int level = 0;
  try {
    for (; level < levels; ++level) {
      const v1::Case fine = level_of(checked, level).description;
      const int refinement = fine.mesh().refinement();
      const v1::Job job = job_of_level(connection, fine, study, attempts[refinement]);
      std::cerr << "refinement " << refinement << ": job " << job.id() << '\n';
    }
  } catch (const Interrupted&) {
    throw Interrupted("part of the study may be in the queue. Come back: " + way_back);
  } catch (const CommandFailed& failure) {
    if (failure.code() == ExitCode::invalid) throw;
    throw CommandFailed(failure.code(), std::string(failure.what()) + "; " + std::to_string(level) +
                                            " of " + std::to_string(levels) +
                                            " runs are submitted. The rest: " + way_back);
  }
  return true;
}

}  // namespace dccast::client
