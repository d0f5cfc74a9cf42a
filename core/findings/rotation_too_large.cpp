#include <numbers>

#include "core/findings/of_step.hpp"
#include "core/findings/sentence.hpp"

namespace dccast::casting {

std::optional<Finding> rotation_too_large(const Case& c, const StepFigures& f) {
  if (f.rotation <= c.validity.maximum_rotation) return std::nullopt;
  return finding_of(
      "rotation_too_large", Severity::danger,
      sentence("A part of the shell has rotated by %.3g degrees since it solidified: a butt that "
               "bends this far jams in the mould or cracks.",
               180.0 / std::numbers::pi * f.rotation),
      {{f.rotation}, c.validity.maximum_rotation, "rad", "validity.maximum_rotation"});
}

}  // namespace dccast::casting
