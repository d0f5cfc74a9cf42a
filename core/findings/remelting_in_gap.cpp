#include "core/findings/of_step.hpp"
#include "core/findings/sentence.hpp"

namespace dccast::casting {

/// A surface that is not yet solid at the end of the mould contact is not a matter of the gap; one
/// that is solid there and melts again does so because of the gap.
std::optional<Finding> remelting_in_gap(const Case& c, const StepFigures& f) {
  const double solidus = c.alloy.solidus;
  if (!f.moves || !f.in_gap || f.gap_entry >= solidus || f.gap_surface.value < solidus)
    return std::nullopt;
  return finding_of("remelting_in_gap", Severity::warning,
                    sentence("In the air gap the surface, which was solid where it left the mould "
                             "wall, is at %.4g degC again, above the solidus of %.6g degC: melt "
                             "sweats out in bands, and may bleed out.",
                             f.gap_surface.value, solidus),
                    {f.gap_surface, solidus, "degC", "alloy.solidus"});
}

}  // namespace dccast::casting
