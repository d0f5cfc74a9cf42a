#pragma once

#include <vector>

namespace dccast {

/// The abscissa of a Curve, in SI units and °C.
enum class Abscissa { none, time, cast_length, temperature, gap, distance, liquid_fraction };

/// A quantity given as a table, [unit of the quantity]: interpolated linearly, constant outside.
///
/// The constant continuation is deliberate and documented for the user: tables of material data end
/// where the measurements end, and a linear extrapolation of a modulus or a conductivity can change
/// its sign.
class Curve {
public:
  /// An empty curve; evaluating it is a bug. Use `empty()` to tell an optional curve apart.
  Curve() = default;
  /// A constant.
  explicit Curve(double value) : at_{0.0}, value_{value} {}  ///< [quantity]
  /// @param at     abscissae [their unit], strictly increasing (checked where the case is checked)
  /// @param value  ordinates [quantity], as many as abscissae
  Curve(Abscissa abscissa, std::vector<double> at, std::vector<double> value);

  double operator()(double x) const;  ///< [quantity] at `x` [abscissa]
  /// Derivative [quantity/abscissa] at `x` [abscissa]; at a point of the table the right-hand one;
  /// zero outside.
  double derivative(double x) const;
  /// Exact integral [quantity * abscissa]. @param a  lower limit [abscissa] @param b  upper limit
  /// [abscissa]
  double integral(double a, double b) const;

  bool empty() const { return at_.empty(); }
  bool constant() const { return at_.size() == 1; }
  Abscissa abscissa() const { return abscissa_; }
  const std::vector<double>& at() const { return at_; }        ///< [abscissa]
  const std::vector<double>& value() const { return value_; }  ///< [quantity]

private:
  Abscissa abscissa_ = Abscissa::none;
  std::vector<double> at_;     ///< [abscissa]
  std::vector<double> value_;  ///< [quantity]
};

}  // namespace dccast
