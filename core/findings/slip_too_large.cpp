#include "core/findings/of_step.hpp"
#include "core/findings/sentence.hpp"

namespace dccast::casting {

/// Worded as for a run that stops at the loss; a run that continues may reach it after another
/// loss.
std::optional<Finding> slip_too_large(const Case& c, const StepFigures& f) {
  if (f.slip <= c.validity.maximum_slip) return std::nullopt;
  return finding_of(
      "slip_too_large", Severity::danger,
      sentence("The butt has slid %.3g mm over the bottom block beyond its contraction: its shell "
               "is open or nothing holds it on the block, and the slab hangs or bleeds.",
               in_mm * f.slip),
      {{f.slip}, c.validity.maximum_slip, "m", "validity.maximum_slip"});
}

}  // namespace dccast::casting
