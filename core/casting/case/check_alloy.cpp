#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/casting/case/checks.hpp"
#include "core/material/thermal_properties.hpp"

namespace dccast::casting {

namespace {

/// Checks that the table contains both ends, or a part of the latent heat would never be released.
void liquid_fraction(CaseFindings& found) {
  const material::AlloyCard& a = found.casting.alloy;
  const Curve& f = a.liquid_fraction;
  const bool spans = !f.constant() && f.at().front() == a.solidus && f.value().front() == 0.0 &&
                     f.at().back() == a.liquidus && f.value().back() == 1.0;
  if (!spans || !std::ranges::is_sorted(f.value()))
    found.fault("alloy.liquid_fraction", "table",
                "does not rise from 0 at the solidus to 1 at the liquidus",
                "first point [" + with_unit(a.solidus, "degC") + ", 0], last point [" +
                    with_unit(a.liquidus, "degC") + ", 1], never falling between them",
                "complete the table, or leave it out for a linear liquid fraction");
}

/// Checks the coherency temperature, and that a solid fraction given for it means the same.
void coherency(CaseFindings& found) {
  const material::AlloyCard& a = found.casting.alloy;
  if (a.coherency > a.liquidus || a.coherency < a.solidus - 100.0)
    found.fault("alloy.coherency", with_unit(a.coherency, "degC"),
                "is not a temperature of the mush",
                "up to alloy.liquidus = " + with_unit(a.liquidus, "degC") +
                    ", not more than 100 K below alloy.solidus = " + with_unit(a.solidus, "degC"),
                "leave it out to take the liquidus");

  // A case may give the coherency by temperature or by solid fraction, but not both differently.
  constexpr double same = 1e-6;  // [K]
  const auto& solid_fraction = found.casting.coherency_solid_fraction;
  if (!solid_fraction) return;
  const double meant = material::coherency_at(a, *solid_fraction);
  if (std::abs(meant - a.coherency) > same)
    found.fault("alloy.coherency_solid_fraction", *solid_fraction,
                "is " + with_unit(meant, "degC") + ", and alloy.coherency is given beside it",
                "either alloy.coherency_solid_fraction or alloy.coherency",
                "leave alloy.coherency out: the solid fraction follows the card");
}

/// Checks that metal carries no load before it holds melt back: otherwise it would be solid and
/// melt at once. The paper's mush, which is as strong as the solid, keeps the coherency of the
/// case.
void onset_of_stress(CaseFindings& found) {
  const material::AlloyCard& a = found.casting.alloy;
  const auto& onset = found.casting.coherency_solid_fraction;
  if (!a.mush || !onset || a.coherency >= a.retention_temperature()) return;

  const double retention = material::solid_fraction_at(a, a.retention_temperature());
  found.fault("alloy.coherency_solid_fraction", *onset,
              "lies above the solid fraction from which metal does not flow out of a shell: metal "
              "that holds melt back already carries load",
              fmt::format("at most {:.4g}, alloy.retention_solid_fraction", retention),
              "lower it, or raise alloy.retention_solid_fraction or alloy.shell_solid_fraction");
}

/// Checks that the window of hot tears starts before it ends.
void hot_tear_window(CaseFindings& found) {
  const material::HotTearWindow& window = found.casting.alloy.hot_tears;
  if (window.end >= window.start) return;
  found.fault("alloy.hot_tear_start_solid_fraction", window.start,
              "lies above the end of the window of hot tears",
              fmt::format("at most {:.4g}, alloy.hot_tear_end_solid_fraction", window.end),
              "lower it, or raise alloy.hot_tear_end_solid_fraction; without that key the window "
              "ends at alloy.coalescence_solid_fraction");
}

/// Checks the algorithm of an alloy with a yield limit: the paper's know the creep law only.
void cold_strength(CaseFindings& found) {
  const Case& c = found.casting;
  if (!c.alloy.cold_strength || !c.mechanics.enabled) return;
  if (c.mechanics.options.algorithm == mechanics::Algorithm::newton) return;
  found.fault("mechanics.algorithm", "", "knows no yield limit, and the alloy has one",
              "newton, with alloy.cold_strength",
              "take newton, or an alloy card without cold_strength");
}

}  // namespace

void check_alloy(CaseFindings& found) {
  const material::AlloyCard& a = found.casting.alloy;
  for (const auto& [key, table] :
       {std::pair{"alloy.density", &a.density}, std::pair{"alloy.conductivity", &a.conductivity}})
    if (table->empty() && found.sound({key}))
      found.fault(key, "", "is missing", "a table, or the properties of solid and liquid",
                  std::string("give ") + key + ", or its solid_ and liquid_ keys");

  if (!found.sound({"alloy.solidus", "alloy.liquidus"})) return;
  if (a.solidus > a.liquidus)
    found.fault("alloy.solidus", with_unit(a.solidus, "degC"), "lies above the liquidus",
                "at most alloy.liquidus = " + with_unit(a.liquidus, "degC"),
                "exchange the two, or make them equal for a pure metal");

  // The remaining checks compare temperatures of the mush, which need solidus and liquidus in
  // order.
  if (found.sound({"alloy.solidus", "alloy.coherency"})) coherency(found);
  onset_of_stress(found);
  cold_strength(found);
  hot_tear_window(found);
  if (!a.liquid_fraction.empty() && found.sound({"alloy.solidus", "alloy.liquid_fraction"}))
    liquid_fraction(found);
}

}  // namespace dccast::casting
