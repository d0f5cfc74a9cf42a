#pragma once

#include <string>
#include <vector>

#include "dccast/v1/service.pb.h"
#include "server/intake/case_intake.hpp"
#include "server/service/call.hpp"

namespace dccast::service {

struct Context;

/// The file of a job's results, as the artifact is named.
inline constexpr const char* results_file = "results.h5";

/// @return null where the job has no such result
const v1::Artifact* artifact_of(const v1::Job& job, const std::string& name);

/// A frame of a job with the times of all, from its results or from the journal of its run, read by
/// a worker; without a frame where there is no such one.
v1::QueryResultResponse read_frame(Context& context, const Call& call, const v1::Job& job,
                                   const intake::FrameChoice& choice);

/// All accepted steps of a job so far, each once. @throws std::exception  the event log cannot be
/// read
std::vector<v1::StepReport> read_steps(Context& context, const std::string& job);

}  // namespace dccast::service
