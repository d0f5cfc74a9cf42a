#pragma once

#include <vector>

namespace dccast {

/// Quantity that the abscissa of a Curve measures, in SI units and °C.
enum class Abscissa { none, time, cast_length, temperature, gap, distance, liquid_fraction };

/// A quantity given as a table, [unit of the quantity]: interpolated linearly, constant outside.
///
/// The constant continuation is deliberate and documented for the user: tables of material data end
/// where the measurements end, and a linear extrapolation of a modulus or a conductivity can change
/// its sign.
class Curve {
public:
  /// An empty curve: `empty()` is true, and evaluating it is undefined behaviour. It stands for a
  /// table that the case does not give.
  Curve() = default;
  /// A constant function. @param value  [quantity]
  explicit Curve(double value) : at_{0.0}, value_{value} {}
  /// A piecewise linear function through the points (at, value).
  /// @param at     abscissae [their unit], strictly increasing (checked where the case is checked)
  /// @param value  ordinates [quantity], one for each abscissa
  /// @throws std::logic_error  the two differ in number
  Curve(Abscissa abscissa, std::vector<double> at, std::vector<double> value);

  /// [quantity] at `x` [abscissa]. A table out of order, or with a NaN, gives some value too: a
  /// case is translated before all its faults are known.
  double operator()(double x) const;
  /// Derivative [quantity/abscissa] at `x` [abscissa]; at a point of the table the right-hand one;
  /// zero outside.
  double derivative(double x) const;
  /// Exact integral from `a` to `b` [quantity * abscissa]; negative for b < a where the values are
  /// positive. @param a, b  limits [abscissa]
  double integral(double a, double b) const;

  bool empty() const { return at_.empty(); }             ///< no table was given
  bool constant() const { return at_.size() == 1; }      ///< one point: the same value everywhere
  Abscissa abscissa() const { return abscissa_; }        ///< none for a constant
  const std::vector<double>& at() const { return at_; }  ///< [abscissa]
  const std::vector<double>& value() const { return value_; }  ///< [quantity]

private:
  Abscissa abscissa_ = Abscissa::none;
  std::vector<double> at_;     ///< [abscissa]
  std::vector<double> value_;  ///< [quantity]
};

}  // namespace dccast
