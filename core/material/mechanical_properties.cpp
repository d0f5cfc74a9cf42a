#include "core/material/mechanical_properties.hpp"

#include <algorithm>
#include <cmath>

namespace dccast::material {

MechanicalProperties::MechanicalProperties(const AlloyCard& card)
    : card_(card), creep_(norton_hoff(card)), liquid_density_(card.density(card.liquidus)) {}

double MechanicalProperties::bulk_modulus(double temperature) const {
  return card_.young_modulus(temperature) / (3.0 * (1.0 - 2.0 * card_.poisson_ratio(temperature)));
}

double MechanicalProperties::shear_modulus(double temperature) const {
  return card_.young_modulus(temperature) / (2.0 * (1.0 + card_.poisson_ratio(temperature)));
}

double MechanicalProperties::kappa(double temperature) const {
  return creep_.kappa(std::min(temperature, card_.liquidus));
}

double MechanicalProperties::thermal_stretch(double temperature) const {
  return std::cbrt(liquid_density_ / card_.density(temperature));
}

}  // namespace dccast::material
