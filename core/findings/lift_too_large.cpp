#include <cmath>

#include "core/findings/of_step.hpp"
#include "core/findings/sentence.hpp"

namespace dccast::casting {

/// The chord from the centre to the corner may rotate as little as any part of the shell.
std::optional<Finding> lift_too_large(const Case& c, const StepFigures& f) {
  const double limit = std::tan(c.validity.maximum_rotation) * c.section.half_width;
  if (!f.mechanical || f.lift.value <= limit) return std::nullopt;
  return finding_of("lift_too_large", Severity::danger,
                    sentence("The butt has risen %.4g mm off the bottom block: such a steep butt "
                             "is unstable, and the slab tilts or hangs in the mould.",
                             in_mm * f.lift.value),
                    {f.lift, limit, "m", "validity.maximum_rotation"});
}

}  // namespace dccast::casting
