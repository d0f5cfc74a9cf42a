#include "server/service/run_history.hpp"

#include <iterator>

#include "server/service/context.hpp"

namespace dccast::service {

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
