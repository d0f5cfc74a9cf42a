#include <algorithm>

#include "core/findings/of_step.hpp"
#include "core/findings/sentence.hpp"

namespace dccast::casting {

namespace {

/// A shell that is about to fail has lost this share of its largest thickness, and its remaining
/// thickness is below this multiple of the limit. Sound castings stay above (docs/findings.md).
constexpr double lost_share = 0.4;
constexpr double limits_left = 3.0;

}  // namespace

std::optional<Finding> bottom_shell_fails(const Case& c, const StepFigures& f) {
  const double limit = limits_left * c.plausibility.minimum_shell;
  const double kept = (1.0 - lost_share) * f.thickest_bottom_shell;
  const double shell = f.bottom_shell.value;
  if (!f.moves || !f.mechanical || shell >= limit || shell >= kept) return std::nullopt;
  return finding_of(
      "bottom_shell_fails", Severity::warning,
      sentence(
          "The shell over the bottom block melts again: it was %.3g mm thick and is %.3g mm now. "
          "It is about to fail; keep the contact with the block longer or the gap smaller.",
          in_mm * f.thickest_bottom_shell, in_mm * shell),
      {f.bottom_shell, std::min(limit, kept), "m", "plausibility.minimum_shell"});
}

}  // namespace dccast::casting
