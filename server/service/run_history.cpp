#include "server/service/run_history.hpp"

#include <algorithm>
#include <iterator>

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

std::optional<std::vector<v1::StepReport>> read_steps(Context& context, const std::string& job) {
  constexpr std::size_t most_steps_at_once = 1000;
  constexpr std::size_t most_bytes_at_once = 1'000'000;

  const auto log = context.scheduler.log(job);

  std::vector<v1::StepReport> steps;
  // Page by page: other readers of the same index can take turns.
  for (std::optional<jobs::StepPlace> place(jobs::StepPlace{}); place;) {
    auto page =
        context.step_indexes.of(job)->page(*log, *place, most_steps_at_once, most_bytes_at_once);
    if (!page) return std::nullopt;
    std::move(page->steps.begin(), page->steps.end(), std::back_inserter(steps));
    place = page->next;
  }

  return steps;
}

}  // namespace dccast::service
