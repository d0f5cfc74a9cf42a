#include "core/material/mechanical_properties.hpp"

#include <cmath>
#include <utility>

#include "core/material/thermal_properties.hpp"

namespace dccast::material {

namespace {

/// The density of a card given for the mixture, continued beyond the solidus as solid: with the
/// slope that it has just below.
Curve continued_solid(const AlloyCard& card) {
  if (card.density.constant()) return card.density;

  std::vector<double> at, value;
  for (std::size_t i = 0; i < card.density.at().size(); ++i) {
    if (card.density.at()[i] >= card.solidus) break;
    at.push_back(card.density.at()[i]);
    value.push_back(card.density.value()[i]);
  }
  const double slope = at.empty() ? 0.0 : card.density.derivative(at.back());
  const double at_solidus = card.density(card.solidus);
  at.push_back(card.solidus);
  value.push_back(at_solidus);
  if (card.liquidus > card.solidus) {
    at.push_back(card.liquidus);
    value.push_back(at_solidus + slope * (card.liquidus - card.solidus));
  }
  return Curve(Abscissa::temperature, std::move(at), std::move(value));
}

/// The mush never loses all its strength: below coherency the liquid's modulus takes over.
constexpr double least_strength = 1e-2;  // [1]

/// A solidifying shell deforms at some 1e-5 to 1e-3 /s. In a porous body that shears at this rate a
/// smaller mean stress dilates at a rate proportional to it; alone it would meet the infinite
/// viscosity of a power law at zero, where Newton's method alternates between tension and pressure.
constexpr double rate_of_a_shell = 1e-4;  // [1/s]

}  // namespace

MechanicalProperties::MechanicalProperties(const AlloyCard& card)
    : card_(card),
      creep_(norton_hoff(card)),
      liquid_density_(card.density(card.liquidus)),
      reference_density_(liquid_density_),
      onset_(1.0),
      coalescence_(card.coherency) {
  if (!card_.mush) return;

  // Lengths are counted from the skeleton at its coherency; eq. (11) counts them from the melt.
  if (!card_.solid_density.empty()) reference_density_ = card_.solid_density(card_.coherency);
  if (card_.solid_density.empty()) card_.solid_density = continued_solid(card_);
  onset_ = solid_fraction_at(card_, card_.coherency);
  coalescence_ = std::min(card_.coherency, coherency_at(card_, card_.mush->coalescence));
  tabulate_mush();
}

/// Integrates psi dS_solid from coalescence to coherency. Between the points psi and the stretch of
/// the solid are nearly linear.
void MechanicalProperties::tabulate_mush() {
  constexpr double spacing = 0.1;  // [K]
  const double width = card_.coherency - coalescence_;
  if (width <= 0.0) return;

  const int parts = static_cast<int>(width / spacing) + 1;
  std::vector<double> at{coalescence_}, stretch{solid_stretch(coalescence_)};
  for (int i = 1; i <= parts; ++i) {
    const double low = at.back(), high = coalescence_ + width * i / parts;
    const double bridged = 0.5 * (bridged_share(low) + bridged_share(high));
    at.push_back(high);
    stretch.push_back(stretch.back() + bridged * (solid_stretch(high) - solid_stretch(low)));
  }
  mush_stretch_ = Curve(Abscissa::temperature, std::move(at), std::move(stretch));
}

double MechanicalProperties::solid_stretch(double temperature) const {
  return std::cbrt(reference_density_ / card_.solid_density(temperature));
}

double MechanicalProperties::thermal_stretch(double temperature) const {
  if (!card_.mush) return std::cbrt(liquid_density_ / card_.density(temperature));

  if (temperature >= coalescence_ && !mush_stretch_.empty()) return mush_stretch_(temperature);
  const double within = std::min(temperature, card_.coherency);
  const double unfed = card_.mush->unfed_strain_share * unfed_shrinkage(within) / 3.0;
  return solid_stretch(within) - unfed;
}

/// Loss of volume since coalescence that the contraction of the solid does not explain [1].
double MechanicalProperties::unfed_shrinkage(double temperature) const {
  const double end = card_.mush ? coherency_at(card_, card_.mush->coalescence) : card_.solidus;
  if (temperature >= end) return 0.0;
  const double mixture = std::log(card_.density(temperature) / card_.density(end));
  const double solid = std::log(card_.solid_density(temperature) / card_.solid_density(end));
  return std::max(0.0, mixture - solid);
}

double MechanicalProperties::pore_share(double temperature) const {
  if (!card_.mush) return 0.0;
  return (1.0 - card_.mush->unfed_strain_share) * unfed_shrinkage(temperature);
}

double MechanicalProperties::bridged_share(double temperature) const {
  if (!card_.mush || temperature <= coalescence_) return 1.0;
  if (temperature >= card_.coherency) return 0.0;
  const double solid = solid_fraction_at(card_, temperature);
  return std::clamp((solid - onset_) / (card_.mush->coalescence - onset_), 0.0, 1.0);
}

double MechanicalProperties::relative_strength(double temperature) const {
  if (!card_.mush) return 1.0;
  const double liquid = liquid_fraction_at(card_, temperature);
  if (liquid <= 0.0) return 1.0;
  return std::max(least_strength,
                  bridged_share(temperature) * std::exp(-card_.mush->strength_decay * liquid));
}

CreepFactors MechanicalProperties::creep_factors(double temperature) const {
  const double solid = creep_.kappa(std::min(temperature, card_.liquidus));
  const double strength = relative_strength(temperature);
  if (strength >= 1.0) return {.deviatoric = solid};

  const double n = creep_.exponent - 1.0;
  const double mush = solid * std::pow(strength, -n);
  // Porosity through which melt can move: all melt at coherency, none once the grains have grown
  // together.
  const double porosity =
      (1.0 - bridged_share(temperature)) * liquid_fraction_at(card_, temperature);
  const double ratio = porous_ratio(porosity, n);
  if (ratio <= 0.0) return {.deviatoric = mush};
  return {.deviatoric = mush,
          .volumetric = mush * ratio,
          .linear_below = mean_stress_like(std::pow(rate_of_a_shell / mush, 1.0 / n), ratio, n)};
}

YieldLimit MechanicalProperties::yield_limit(double temperature) const {
  static const double norm_of_uniaxial = std::sqrt(2.0 / 3.0);
  return {norm_of_uniaxial * card_.cold_strength->yield_stress(temperature),
          card_.cold_strength->hardening(temperature)};
}

}  // namespace dccast::material
