#include "client/session/mould_design.hpp"

#include "client/session/connection.hpp"
#include "client/session/failure.hpp"
#include "client/session/jobs.hpp"
#include "client/session/studies.hpp"
#include "proto/frames/contraction.hpp"

namespace dccast::client {
namespace {

void read_cast(Connection& connection, MouldRun& run) {
  v1::QueryResultResponse result;
  const grpc::Status status = try_query_result(connection, run.job, true, result);
  if (!status.ok()) {
    run.reason = status.error_message();
    return;
  }
  try {
    run.cast =
        CastMould{result.case_().section(),
                  frames::steady_face(frames::contraction_of(result.case_(), result.frame()))};
  } catch (const frames::NoContraction& reason) {
    run.reason = reason.what();
  }
}

/// The value of the plan, or the opening at the narrow face of the mould that the first run had.
double wanted_of(const v1::MouldPlan& plan, const std::vector<MouldRun>& runs) {
  if (plan.wanted_half_thickness_m() > 0.0) return plan.wanted_half_thickness_m();
  if (runs.empty() || !runs.front().cast) return 0.0;
  const v1::Section& section = runs.front().cast->section;
  return frames::half_opening_m(section, section.half_width_m());
}

}  // namespace

const MouldRun* MouldDesign::best() const {
  const MouldRun* best = nullptr;
  for (const MouldRun& run : runs)
    if (run.cast && (best == nullptr ||
                     run.cast->face.residual_m(wanted_m) < best->cast->face.residual_m(wanted_m)))
      best = &run;
  return best;
}

bool MouldDesign::steady() const {
  const MouldRun* run = best();
  return run != nullptr && run->cast->face.change_m <= result.study().mould().tolerance_m();
}

MouldDesign read_mould_design(Connection& connection, const std::string& study) {
  MouldDesign design{evaluate_study(connection, study), 0.0, {}};
  if (!design.result.study().has_mould())
    throw CommandFailed(
        ExitCode::invalid,
        "study " + study + " designs no mould; dccast studies show " + study + " shows what it is");
  for (const v1::StudyRun& run : design.result.runs()) {
    MouldRun& read = design.runs.emplace_back();
    read.job = run.job();
    read.state = run.state();
    read.reason = run.failure().message();
    if (run.state() == v1::SUCCEEDED) read_cast(connection, read);
  }
  design.wanted_m = wanted_of(design.result.study().mould(), design.runs);
  return design;
}

}  // namespace dccast::client
