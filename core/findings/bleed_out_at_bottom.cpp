#include "core/findings/of_step.hpp"
#include "core/findings/open_gap.hpp"
#include "core/findings/sentence.hpp"

namespace dccast::casting {

std::optional<Finding> bleed_out_at_bottom(const Case& c, const StepFigures& f) {
  if (!bottom_shell_is_thin(c, f) || f.gap_under_shell < open_gap) return std::nullopt;
  return finding_of(
      "bleed_out_at_bottom", Severity::danger,
      sentence(
          "Over a gap of %.3g mm to the bottom block the shell is %.3g mm thick, less than %.3g "
          "mm: nothing supports it there, and melt runs into the gap and onto the block.",
          in_mm * f.gap_under_shell, in_mm * f.bottom_shell.value,
          in_mm * c.plausibility.minimum_shell),
      {f.bottom_shell, c.plausibility.minimum_shell, "m", "plausibility.minimum_shell"});
}

}  // namespace dccast::casting
