#include "core/findings/of_step.hpp"
#include "core/findings/sentence.hpp"

namespace dccast::casting {

namespace {

constexpr const char* code = "bleed_out_at_exit";

Finding hot_surface(const Case& c, const StepFigures& f) {
  return finding_of(code, Severity::danger,
                    sentence("The surface leaves the mould at %.4g degC, above the solidus of %.6g "
                             "degC: nothing solid holds the melt there, and it runs out.",
                             f.exit_surface.value, c.alloy.solidus),
                    {f.exit_surface, c.alloy.solidus, "degC", "alloy.solidus"});
}

Finding thin_shell(const Case& c, const StepFigures& f) {
  const double limit = c.plausibility.minimum_shell;
  return finding_of(
      code, Severity::danger,
      sentence("The shell leaves the mould %.3g mm thick, less than %.3g mm: a scratch, a hang-up "
               "in the mould or a short loss of water lets the melt through.",
               in_mm * f.exit_shell.value, in_mm * limit),
      {f.exit_shell, limit, "m", "plausibility.minimum_shell"});
}

}  // namespace

std::optional<Finding> bleed_out_at_exit(const Case& c, const StepFigures& f) {
  if (!f.moves || !f.left_mould) return std::nullopt;
  if (f.exit_surface.value >= c.alloy.solidus) return hot_surface(c, f);
  if (f.exit_shell.value < c.plausibility.minimum_shell) return thin_shell(c, f);
  return std::nullopt;
}

}  // namespace dccast::casting
