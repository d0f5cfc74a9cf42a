#pragma once

#include <vector>

namespace dccast {

/// What the numbers of a Curve stand against; the unit is that of the quantity in SI and °C.
enum class Abscissa { none, time, cast_length, temperature, gap, distance, liquid_fraction };

/// A quantity given as a table: interpolated linearly, constant outside its range.
///
/// The constant continuation is deliberate and stated to the user: tables of material data end where
/// the measurements end, and a straight-line continuation of a modulus or a conductivity can change
/// its sign.
class Curve {
public:
  /// An empty curve; evaluating it is a bug. Use `empty()` to tell an optional curve apart.
  Curve() = default;
  /// A constant.
  explicit Curve(double value) : at_{0.0}, value_{value} {}
  /// @param at     abscissae, strictly increasing (checked where the case is checked)
  /// @param value  ordinates, as many as abscissae
  Curve(Abscissa abscissa, std::vector<double> at, std::vector<double> value);

  double operator()(double x) const;
  /// Derivative; at a point of the table that of the interval to its right, zero outside the table.
  double derivative(double x) const;
  /// Integral from `a` to `b`, exact.
  double integral(double a, double b) const;

  bool empty() const { return at_.empty(); }
  bool constant() const { return at_.size() == 1; }
  Abscissa abscissa() const { return abscissa_; }
  const std::vector<double>& at() const { return at_; }
  const std::vector<double>& value() const { return value_; }

private:
  Abscissa abscissa_ = Abscissa::none;
  std::vector<double> at_;
  std::vector<double> value_;
};

}  // namespace dccast
