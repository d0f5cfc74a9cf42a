#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <variant>
#include <vector>

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
  if (!a.mush || !onset || a.coherency >= a.shell_temperature()) return;

  const double shell = material::solid_fraction_at(a, a.shell_temperature());
  found.fault("alloy.coherency_solid_fraction", *onset,
              "lies above the solid fraction from which metal does not flow out of a shell: metal "
              "that holds melt back already carries load",
              fmt::format("at most {:.4g}, alloy.shell_solid_fraction", shell),
              "lower it, or raise alloy.shell_solid_fraction");
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

constexpr const char* mend_card =
    "add it to the card or to [alloy]; `dccast alloys aa5182` shows a complete card";

/// Reports a figure or table that a law of the case needs and the alloy does not have.
void need(CaseFindings& found, const std::string& key, bool is_given, const std::string& permitted,
          const std::string& reason = "", const std::string& remedy = mend_card) {
  if (!is_given && found.sound({key}))
    found.fault(key, "", "is missing" + reason, permitted, remedy);
}

/// Checks a property that is a table, or mixed of those of solid and liquid.
void need_property(CaseFindings& found, const std::string& name, const Curve& table) {
  const std::string solid = "alloy.solid_" + name, liquid = "alloy.liquid_" + name;
  if (!found.sound({solid, liquid})) return;
  need(found, "alloy." + name, !table.empty(), "a table, or " + solid + " and " + liquid, "",
       "give alloy." + name + ", or both " + solid + " and " + liquid);
}

/// Checks for everything that the heat needs, and the state of the mush.
void need_heat(CaseFindings& found) {
  using material::is_given;
  const material::AlloyCard& a = found.casting.alloy;

  need(found, "alloy.liquidus", is_given(a.liquidus), "a temperature");
  need(found, "alloy.solidus", is_given(a.solidus), "a temperature, at most alloy.liquidus");
  need(found, "alloy.latent_heat", is_given(a.latent_heat),
       "a heat, or 0 J/kg where alloy.specific_heat contains the heat of freezing");
  need(found, "alloy.specific_heat", !a.specific_heat.empty(), "a value or a table");

  // Solid and liquid are mixed over the mush, which these temperatures give.
  if (!found.sound({"alloy.liquidus", "alloy.solidus"})) return;
  need_property(found, "density", a.density);
  need_property(found, "conductivity", a.conductivity);
  if (found.sound({"alloy.coherency"}))
    need(found, "alloy.coherency_solid_fraction", is_given(a.coherency),
         "a solid fraction, or a temperature as alloy.coherency",
         ": it tells from where on metal carries stress, and where the sump ends",
         "write coherency_solid_fraction = 0.9, as most shipped cards do");
}

/// The figures of a creep law, by their keys.
std::vector<std::pair<const char*, double>> figures_of(const material::NortonHoffConstants& law) {
  return {{"alloy.norton_hoff.material_resistance", law.material_resistance},
          {"alloy.norton_hoff.shear_limit", law.shear_limit},
          {"alloy.norton_hoff.activation_energy", law.activation_energy},
          {"alloy.norton_hoff.exponent", law.exponent}};
}
std::vector<std::pair<const char*, double>> figures_of(const material::ReferenceCreep& law) {
  return {{"alloy.reference_creep.stress", law.stress},
          {"alloy.reference_creep.strain_rate", law.strain_rate},
          {"alloy.reference_creep.temperature", law.temperature},
          {"alloy.reference_creep.stress_exponent", law.stress_exponent},
          {"alloy.reference_creep.activation_energy", law.activation_energy}};
}

/// Checks that there is a creep law, and that it is complete.
void need_creep(CaseFindings& found) {
  const auto figures =
      std::visit([](const auto& law) { return figures_of(law); }, found.casting.alloy.creep);
  const auto is_given = [](const auto& figure) { return material::is_given(figure.second); };

  if (std::ranges::none_of(figures, is_given)) {
    need(found, "alloy.reference_creep", !found.sound({"alloy.norton_hoff"}),
         "one creep law: alloy.reference_creep, or alloy.norton_hoff");
    return;
  }
  for (const auto& [key, value] : figures)
    need(found, key, material::is_given(value), "a number, as all figures of a creep law");
}

/// Checks for everything that the mechanics needs.
void need_mechanics(CaseFindings& found) {
  const material::AlloyCard& a = found.casting.alloy;
  need(found, "alloy.young_modulus", !a.young_modulus.empty(), "a value or a table");
  need(found, "alloy.poisson_ratio", !a.poisson_ratio.empty(), "a value or a table");
  need_creep(found);
  if (a.cold_strength)
    need(found, "alloy.cold_strength.yield_stress", !a.cold_strength->yield_stress.empty(),
         "a value or a table", ", and alloy.cold_strength.hardening is given",
         "give the yield stress, or leave alloy.cold_strength out");
}

/// Checks that solid metal contracts as it cools. A constant density moves nothing.
/// @pre solidus and densities are sound
void contraction(CaseFindings& found) {
  constexpr double cold = 20.0;  // [°C]
  const material::AlloyCard& a = found.casting.alloy;
  const double hot = std::min(a.solidus, a.coherency);
  const auto falls = [&](const Curve& density) { return density(cold) > density(hot); };

  // Without a law of the mush the solid contracts as the mixture, which may be mixed from it.
  const bool of_solid = !a.solid_density.empty() && !falls(a.solid_density);
  const bool has_own = !a.solid_density.empty() && a.mush;
  if (!(has_own ? of_solid : !falls(a.density))) return;
  const Curve& density = of_solid ? a.solid_density : a.density;

  found.fault(of_solid ? "alloy.solid_density" : "alloy.density", with_unit(density(cold), "kg/m3"),
              fmt::format("is {} at {} and at {}: solid metal would contract nothing, and no slab "
                          "would curl",
                          density(cold) == density(hot) ? "the same" : "not more",
                          with_unit(cold, "degC"), with_unit(hot, "degC")),
              "a table that falls with the temperature up to the solidus",
              R"(give two points at least, as [["0 degC", "2650 kg/m3"], ["640 degC", )"
              R"("2500 kg/m3"]], or write mechanics.enabled = false)");
}

/// Checks for a mush, in which the strength of the metal grows. A pure metal would get all of it at
/// once, where the equilibrium has no solution.
void freezing_range(CaseFindings& found) {
  constexpr double least = 1.0;  // [K]
  const material::AlloyCard& a = found.casting.alloy;
  if (a.liquidus - a.solidus >= least) return;
  found.fault(
      "alloy.solidus", with_unit(a.solidus, "degC"),
      fmt::format("lies {} the liquidus: metal that freezes at one temperature has no mush, "
                  "in which its strength could grow",
                  a.solidus == a.liquidus ? "at" : "less than 1 K below"),
      "with mechanics at most " + with_unit(a.liquidus - least, "degC") +
          ", 1 K below alloy.liquidus",
      "write solidus = \"" + with_unit(a.liquidus - least, "degC") +
          "\", or mechanics.enabled = false, which computes the heat of a pure metal");
}

/// Warns of a table of the specific heat with a peak in the mush, as a calorimeter shows the latent
/// heat: it would count twice.
void heat_of_freezing(CaseFindings& found) {
  constexpr double beside = 30.0;  // the peak of a calorimeter is wider than the mush [K]
  constexpr double most = 0.2;     // of the latent heat, that a table may rise for other reasons
  const material::AlloyCard& a = found.casting.alloy;
  if (a.specific_heat.constant() || !(a.latent_heat > 0.0)) return;

  const double begin = a.solidus - beside, end = a.liquidus + beside;
  const double without_peak = 0.5 * (a.specific_heat(begin) + a.specific_heat(end)) * (end - begin);
  const double heat = a.specific_heat.integral(begin, end) - without_peak;
  if (heat < most * a.latent_heat) return;

  found.warning("alloy.latent_heat", with_unit(a.latent_heat, "J/kg"),
                fmt::format("alloy.specific_heat has a peak of {:.3g} J/kg between {} and {}: the "
                            "latent heat seems to count twice",
                            heat, with_unit(begin, "degC"), with_unit(end, "degC")),
                "latent_heat beside a table without the peak, or a table with it",
                "write latent_heat = \"0 J/kg\", or take the peak out of alloy.specific_heat");
}

}  // namespace

void check_alloy(CaseFindings& found) {
  const Case& c = found.casting;
  const material::AlloyCard& a = c.alloy;
  need_heat(found);
  const bool has_mechanics = c.mechanics.enabled && found.sound({"mechanics.enabled"});
  if (has_mechanics) need_mechanics(found);

  if (!found.sound({"alloy.solidus", "alloy.liquidus"})) return;
  if (a.solidus > a.liquidus)
    found.fault("alloy.solidus", with_unit(a.solidus, "degC"), "lies above the liquidus",
                "at most alloy.liquidus = " + with_unit(a.liquidus, "degC"),
                has_mechanics ? "exchange the two, or set them 1 K apart for a pure metal"
                              : "exchange the two, or make them equal for a pure metal");
  else if (has_mechanics)
    freezing_range(found);

  // The remaining checks compare temperatures of the mush, which need solidus and liquidus in
  // order.
  hot_tear_window(found);
  if (found.sound({"alloy.latent_heat", "alloy.specific_heat"})) heat_of_freezing(found);
  cold_strength(found);
  if (!a.liquid_fraction.empty() && found.sound({"alloy.solidus", "alloy.liquid_fraction"}))
    liquid_fraction(found);
  if (!found.sound({"alloy.solidus", "alloy.coherency", "alloy.coherency_solid_fraction"})) return;
  coherency(found);
  onset_of_stress(found);
  // A density that is mixed is not there as long as one of both is at fault.
  if (has_mechanics &&
      found.sound({"alloy.density", "alloy.solid_density", "alloy.liquid_density"}))
    contraction(found);
}

}  // namespace dccast::casting
