#include "core/material/yosida.hpp"

#include <cmath>

#include "core/material/norton_hoff.hpp"

namespace dccast::material {

double yosida_root(double load, double exponent) {
  if (load < 1e-18) return 1.0 + load;
  const double m = exponent - 1.0;
  double eta = 1.0 + (load < 1.0 ? load : std::pow(load, 1.0 / m));
  constexpr int most = 60;
  for (int i = 0; i < most; ++i) {
    const double power = creep_power(eta, exponent);  // eta^(q-2)
    const double slope = m * power - (exponent - 2.0) * power / eta;
    const double step = (power * (eta - 1.0) - load) / slope;
    eta -= step;
    if (std::abs(step) <= 1e-15 * eta) break;
  }
  return eta;
}

}  // namespace dccast::material
