#pragma once

#include <span>
#include <vector>

#include "core/thermal/cooling_spec.hpp"

namespace dccast::thermal {

/// Conduction through the thickness of the bottom block below one point of the slab, by implicit
/// Euler.
///
/// All columns have the same matrix. The temperature of the surface at the end of a step is
/// free + compliance * q, with q the flux into the block, so that a step of the slab needs no
/// unknowns of the block.
class BlockColumns {
public:
  static constexpr std::size_t points = 13;  ///< of a column, the surface first

  explicit BlockColumns(const BlockBody& body)
      : body_(body), cell_(body.thickness / double(points - 1)) {}

  /// Factorises the matrix of a step: lumped heat capacity, half a cell at both ends, symmetric and
  /// tridiagonal.
  /// @param time_step  [s]
  void begin_step(double time_step) {
    if (time_step == time_step_) return;
    time_step_ = time_step;

    // Diagonal, and elimination of the entries below it.
    const double conductance = body_.conductivity / cell_;
    const double storage = body_.heat_capacity * cell_ / time_step;
    pivot_.assign(points, storage + 2.0 * conductance);
    pivot_.front() = 0.5 * storage + conductance;
    pivot_.back() = 0.5 * storage + conductance + body_.cooling_coefficient;

    lower_.assign(points, 0.0);
    for (std::size_t i = 1; i < points; ++i) {
      lower_[i] = -conductance / pivot_[i - 1];
      pivot_[i] += lower_[i] * conductance;
    }

    // Response of the surface to a unit flux.
    std::vector<double> unit(points, 0.0);
    unit.front() = 1.0;
    solve(unit);
    compliance_ = unit.front();
  }
  /// Surface temperature [°C] at the end of the step if no heat flows in from above.
  /// @param column  (point) [°C] at the start @param below  [°C] of the surroundings below
  double free_surface(std::span<const double> column, double below) const {
    std::vector<double> after(column.begin(), column.end());
    finish(0.0, below, after);
    return after.front();
  }
  /// Temperature rise of the surface per unit of flux that enters during the step [m2 K/W].
  double compliance() const { return compliance_; }
  /// Completes the step. @param flux  [W/m2] into the surface @param column  overwritten
  void finish(double flux, double below, std::span<double> column) const {
    const double storage = body_.heat_capacity * cell_ / time_step_;
    std::vector<double> right(points);
    for (std::size_t i = 0; i < points; ++i)
      right[i] = (i == 0 || i + 1 == points ? 0.5 : 1.0) * storage * column[i];

    right.front() += flux;
    right.back() += body_.cooling_coefficient * below;

    solve(right);
    for (std::size_t i = 0; i < points; ++i) column[i] = right[i];
  }
  /// Heat of a column above 0 °C [J/m2].
  double heat(std::span<const double> column) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < points; ++i)
      sum += (i == 0 || i + 1 == points ? 0.5 : 1.0) * column[i];
    return sum * cell_ * body_.heat_capacity;
  }

private:
  /// Solves the tridiagonal system of a column. @param right  right-hand side, then solution
  void solve(std::vector<double>& right) const {
    const double conductance = body_.conductivity / cell_;
    for (std::size_t i = 1; i < points; ++i) right[i] -= lower_[i] * right[i - 1];
    right.back() /= pivot_.back();
    for (std::size_t i = points - 1; i-- > 0;)
      right[i] = (right[i] + conductance * right[i + 1]) / pivot_[i];
  }

  BlockBody body_;
  double cell_;                        ///< [m]
  double time_step_ = 0.0;             ///< [s]
  double compliance_ = 0.0;            ///< [m2 K/W]
  std::vector<double> pivot_, lower_;  ///< [W/(m2 K)], [1] factors of the matrix
};

}  // namespace dccast::thermal
