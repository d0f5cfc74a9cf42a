#include "core/findings/of_case.hpp"
#include "core/findings/sentence.hpp"
#include "core/material/liquid_fraction.hpp"

namespace dccast::casting {

namespace {

/// A mush carries tension only where its grains have grown together; below half it is a slurry
/// [A, docs/findings.md].
constexpr double least_solid_fraction = 0.5;

}  // namespace

/// The liquidus is a choice of its own, the paper's; a temperature just below it is none of a card.
std::optional<Finding> coherency_in_liquid(const Case& c, const Course&) {
  const material::AlloyCard& alloy = c.alloy;
  if (!c.mechanics.enabled || c.mechanics.options.liquid == mechanics::Liquid::solid)
    return std::nullopt;
  if (alloy.coherency >= alloy.liquidus) return std::nullopt;
  const double solid = material::solid_fraction_at(alloy, alloy.coherency);
  const bool below_solidus = alloy.coherency < alloy.solidus;
  if (solid >= least_solid_fraction && !below_solidus) return std::nullopt;
  const std::string place =
      below_solidus ? sentence("%.6g K below the solidus", alloy.solidus - alloy.coherency)
                    : sentence("where %.3g of the metal is solid", solid);
  return finding_of("coherency_in_liquid", Severity::warning,
                    sentence("Metal carries stress below a coherency of %.6g degC, %s (solidus "
                             "%.6g, liquidus %.6g degC): a value of another alloy, which changes "
                             "the curl silently? Write alloy.coherency_solid_fraction.",
                             alloy.coherency, place.c_str(), alloy.solidus, alloy.liquidus),
                    {{solid}, least_solid_fraction, "1", "alloy.coherency"});
}

}  // namespace dccast::casting
