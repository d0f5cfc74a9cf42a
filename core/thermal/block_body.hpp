#pragma once

#include <span>
#include <vector>

#include "core/thermal/cooling_spec.hpp"

namespace dccast::thermal {

/// Conduction through the thickness of the bottom block under one point of the slab, implicit Euler.
///
/// All columns have the same matrix, and the temperature of the surface at the end of a step is
/// free + compliance * q, with q the flux into the block: so a step of the slab needs no further
/// unknowns.
class BlockColumns {
public:
  static constexpr std::size_t points = 13;  ///< of a column, the surface first

  explicit BlockColumns(const BlockBody& body);

  /// @param time_step  [s]
  void begin_step(double time_step);
  /// Surface temperature [°C] at the end of the step if no heat flows in from above.
  /// @param column  (point) [°C] at the start @param below  [°C] of the surroundings below
  double free_surface(std::span<const double> column, double below) const;
  /// [m2 K/W] by which a flux that enters during the step warms the surface.
  double compliance() const { return compliance_; }
  /// Completes the step. @param flux  [W/m2] into the surface @param column  overwritten
  void finish(double flux, double below, std::span<double> column) const;
  /// [J/m2] heat of a column above 0 °C.
  double heat(std::span<const double> column) const;

private:
  void solve(std::vector<double>& right) const;

  BlockBody body_;
  double cell_;                                ///< [m]
  double time_step_ = 0.0;                     ///< [s]
  double compliance_ = 0.0;                    ///< [m2 K/W]
  std::vector<double> pivot_, lower_;          ///< [W/(m2 K)], [1] factors of the matrix
};

}  // namespace dccast::thermal
