#include "client/study_submission.hpp"

#include <iostream>

#include "client/divided_case.hpp"
#include "client/render/progress.hpp"
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

v1::Job submit_level(Connection& connection, const CaseUnderCheck& fine, const std::string& study) {
  v1::SubmitJobRequest request;
  request.set_request_id(study + "/" + std::to_string(fine.description.mesh().refinement()));
  request.set_study(study);
  request.set_priority(v1::LOW);  // a study must not stand in the way of a question
  *request.mutable_case_() = fine.description;
  for (const v1::Attachment& attachment : fine.read.attachments)
    *request.add_attachments() = attachment;
  v1::Job job;
  const grpc::Status status = submit_patiently(connection, request, job);
  if (status.error_code() == grpc::StatusCode::ALREADY_EXISTS)
    throw CommandFailed(ExitCode::invalid,
                        "study " + study + " has a run of another case with this refinement" +
                            ". Take it up without FILE, or begin a new one without --study");
  check(status, connection.server());
  return job;
}

}  // namespace

bool submit_study(Connection& connection, const CaseUnderCheck& checked, const std::string& study,
                  int levels) {
  if (!check_levels(connection, checked, levels)) return false;
  const std::string way_back = "dccast convergence --study " + study + " --levels " +
                               std::to_string(levels) + " " + checked.read.source.file();
  int level = 0;
  try {
    for (; level < levels; ++level) {
      const CaseUnderCheck fine = level_of(checked, level);
      const v1::Job job = submit_level(connection, fine, study);
      std::cerr << "refinement " << fine.description.mesh().refinement() << ": job " << job.id()
                << '\n';
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
