#include "core/findings/of_step.hpp"
#include "core/findings/sentence.hpp"

namespace dccast::casting {

std::optional<Finding> sump_too_deep(const Case& c, const StepFigures& f) {
  const double share = f.sump_depth / f.metal_depth;
  if (!f.moves || share <= c.plausibility.maximum_sump_share) return std::nullopt;
  return finding_of(
      "sump_too_deep", Severity::danger,
      sentence("The sump is %.4g mm deep and the slab %.4g mm long: it is liquid nearly to the "
               "bottom block, and any opening in the butt drains it.",
               in_mm * f.sump_depth, in_mm * f.metal_depth),
      {{share}, c.plausibility.maximum_sump_share, "1", "plausibility.maximum_sump_share"});
}

}  // namespace dccast::casting
