#include "core/findings/of_step.hpp"
#include "core/findings/open_gap.hpp"
#include "core/findings/sentence.hpp"

namespace dccast::casting {

/// A shell in contact with the block, such as that of a billet near its axis, is supported by the
/// block.
std::optional<Finding> bottom_shell_open(const Case& c, const StepFigures& f) {
  if (!bottom_shell_is_thin(c, f) || f.gap_under_shell >= open_gap) return std::nullopt;
  return finding_of(
      "bottom_shell_open", Severity::warning,
      sentence(
          "The shell over the bottom block is %.3g mm thick where it rests on the block, less than "
          "%.3g mm: the block carries the melt now, and it bleeds as soon as the butt lifts there.",
          in_mm * f.bottom_shell.value, in_mm * c.plausibility.minimum_shell),
      {f.bottom_shell, c.plausibility.minimum_shell, "m", "plausibility.minimum_shell"});
}

}  // namespace dccast::casting
