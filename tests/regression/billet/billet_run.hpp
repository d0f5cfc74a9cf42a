#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/casting/case/case.hpp"

namespace dccast::regression {

/// Where a temperature was measured to lie below the metal level, at one radius.
struct Isotherm {
  double radius;       ///< [m]
  double temperature;  ///< [°C]
  double depth;        ///< [m] below the metal level
};

/// Vreeman, Schloz, Krane 2002, interpolated in their digitised curves: axis, half radius and 2 mm
/// below the surface.
const std::vector<Isotherm>& measured_isotherms();

/// Subroto and others 2021, interpolated in their digitised traces: on the axis, and at 32.5 and
/// 62 mm the mean of two traces, which differ by up to 9 mm. The level stands 100 mm above the
/// mould ring, from which they measured.
const std::vector<Isotherm>& measured_in_aa6008();

/// A whole casting of the billet, as its end shows it.
struct BilletRun {
  std::vector<double> depth;  ///< [m] of the measured isotherms, in their order
  double still = 0.0;         ///< largest relative change of these depths over the last 100 s
  double metal_heat = 0.0;  ///< [W/rad] what the metal brings in, less what it has left at the foot
  double top_heat = 0.0;    ///< [W/rad] conducted in at the metal level, mean of the last 50 s
  double wall_heat = 0.0;   ///< [W/rad] out through the wall, mean of the last 50 s
  double worst_balance = 0.0;  ///< largest relative energy error of any step
  int nodes = 0;
  int steps = 0;

  /// What comes in less what goes out, relative to what goes out.
  double wall_error() const { return (metal_heat + top_heat) / wall_heat - 1.0; }
};

/// @param billet  a heat-only axisymmetric casting of bilinear quadrilaterals that grows
/// @param measured  where the depths of the result are taken
/// @throws SolveFailed  as the run does
BilletRun run_billet(const casting::Case& billet,
                     const std::vector<Isotherm>& measured = measured_isotherms());

/// Mean, and root mean square, of computed less measured depth [m].
struct DepthError {
  double mean;
  double root_mean_square;
};
DepthError depth_error(const BilletRun& run, const std::vector<Isotherm>& measured);

/// The case at another `mesh.refinement`, its time step changed in proportion.
casting::Case refined(casting::Case billet, int refinement);

/// Value at zero cell and step of two that belong to fineness n and 2 n, at first order.
inline double extrapolated(double coarse, double fine) {
  return 2.0 * fine - coarse;
}

/// One thing changed in the case, for the table of what the depths depend on.
struct Variant {
  std::string name;
  casting::Case billet;
};
std::vector<Variant> variants(const casting::Case& billet);

/// Depths of castings whose uncertain data are drawn from a Latin hypercube: the gain of stirring
/// 0 to 19 at 450 mm, water from 20 °C to the stated temperature, metal ± 3 K, conductivity ± 5 %,
/// latent heat ± 3 %, coefficients of mould and gap 0.67 to 1.5 times.
/// @return (member, isotherm) [m]
std::vector<std::vector<double>> depth_ensemble(const casting::Case& billet,
                                                const std::vector<Isotherm>& measured, int members);

}  // namespace dccast::regression
