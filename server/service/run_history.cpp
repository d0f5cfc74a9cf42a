#include "server/service/run_history.hpp"

#include <algorithm>
#include <cstdint>

#include "server/service/context.hpp"

namespace dccast::service {

const v1::Artifact* artifact_of(const v1::Job& job, const std::string& name) {
  const auto found = std::ranges::find(job.artifacts(), name, &v1::Artifact::name);
  return found == job.artifacts().end() ? nullptr : &*found;
}

v1::QueryResultResponse read_frame(Context& context, const Call& call, const v1::Job& job,
                                   const intake::FrameChoice& choice) {
  const v1::Artifact* const results = artifact_of(job, results_file);
  const auto folder = context.jobs_directory / job.id();
  const auto waiting = waiting_time(call, context.settings.checks().timeout_s());
  return results ? context.intake.stored_frame(folder, *results, choice, waiting)
                 : context.intake.frame_so_far(folder, choice, waiting);
}

std::vector<v1::StepReport> read_steps(Context& context, const std::string& job) {
  const auto log = context.scheduler.log(job);
  return context.step_indexes.of(job)->page(*log, {}, SIZE_MAX, SIZE_MAX).value().steps;
}

}  // namespace dccast::service
