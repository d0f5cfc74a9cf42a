#include "core/findings/of_step.hpp"
#include "core/findings/sentence.hpp"

namespace dccast::casting {

/// Screening by a strain limit: docs/findings.md has its source and what it leaves out.
std::optional<Finding> hot_tears(const Case& c, const StepFigures& f) {
  if (f.mush_strain.value <= c.plausibility.maximum_mush_strain) return std::nullopt;
  constexpr double percent = 100.0;
  return finding_of(
      "hot_tears", Severity::warning,
      sentence("Metal between coherency and solidus has been stretched by %.3g %%, more than the "
               "%.3g %% that melt can feed: hot tears are likely there.",
               percent * f.mush_strain.value, percent * c.plausibility.maximum_mush_strain),
      {f.mush_strain, c.plausibility.maximum_mush_strain, "1", "plausibility.maximum_mush_strain"});
}

}  // namespace dccast::casting
