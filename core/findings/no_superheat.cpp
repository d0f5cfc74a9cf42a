#include <algorithm>

#include "core/findings/of_case.hpp"
#include "core/findings/sentence.hpp"

namespace dccast::casting {

namespace {

/// The coldest metal that is poured in [°C].
double coldest(const Case& c, const Course& course) {
  return std::ranges::min(values_in(c.schedule.casting_temperature, course));
}

const char* meaning(const Case& c, double temperature) {
  if (temperature < c.alloy.solidus) return "such metal is solid and cannot be poured";
  return temperature < c.alloy.liquidus
             ? "it freezes in the launder and on the float before it reaches the mould"
             : "it freezes early: cold shuts, and a float that blocks";
}

}  // namespace

std::optional<Finding> no_superheat(const Case& c, const Course& course) {
  const bool poured = c.cooling.top == thermal::Top::pouring && c.thermal.file.empty() &&
                      !c.schedule.casting_temperature.empty();
  if (!poured) return std::nullopt;
  const double temperature = coldest(c, course);
  const double superheat = temperature - c.alloy.liquidus;
  if (superheat >= c.plausibility.minimum_superheat) return std::nullopt;
  const bool below = superheat < 0.0;
  return finding_of(
      "no_superheat", below ? Severity::danger : Severity::warning,
      sentence("The metal is poured in at %.6g degC, %.3g K %s its liquidus of %.6g degC: %s.",
               temperature, below ? -superheat : superheat, below ? "below" : "above",
               c.alloy.liquidus, meaning(c, temperature)),
      {{superheat}, c.plausibility.minimum_superheat, "K", "schedule.casting_temperature"});
}

}  // namespace dccast::casting
