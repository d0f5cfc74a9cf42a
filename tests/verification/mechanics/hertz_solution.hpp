#pragma once

#include <complex>

#include "tests/verification/mechanics/fixed_body.hpp"

namespace dccast::verification {

/// Elastic half-plane y >= 0 in plane strain, pressed without friction on its boundary y = 0
/// (Johnson 1985, chapter 4; the potential is Westergaard's): with Z analytic,
///     s_xx = Re Z - y Im Z',  s_yy = Re Z + y Im Z',  s_xy = -y Re Z'.
class PressedHalfPlane {
public:
  virtual ~PressedHalfPlane() = default;
  /// Stress [Pa]; nowhere needed where the load itself is singular.
  PlaneStress stress(double x, double y) const;
  /// Force on a surface with normal `n`, per area [Pa].
  Vector2 traction(double x, double y, const Vector2& n) const;

protected:
  using Complex = std::complex<double>;
  explicit PressedHalfPlane(double poisson_ratio) : poisson(poisson_ratio) {}
  virtual Complex potential(Complex z) const = 0;   ///< Z [Pa]
  virtual Complex derivative(Complex z) const = 0;  ///< Z' [Pa/m]

  double poisson;
};

/// A force P [N/m] in the origin: Flamant's stresses.
class PointForce : public PressedHalfPlane {
public:
  PointForce(double force, double poisson_ratio) : PressedHalfPlane(poisson_ratio), force_(force) {}

private:
  Complex potential(Complex z) const override;
  Complex derivative(Complex z) const override;

  double force_;
};

/// A force P [N/m] against a rigid cylinder of radius R: Hertz's contact.
class HertzContact : public PressedHalfPlane {
public:
  HertzContact(double force, double radius, double young, double poisson_ratio);

  double half_width() const { return half_width_; }        ///< b [m]
  double peak_pressure() const { return peak_pressure_; }  ///< p0 [Pa]
  double pressure(double x) const;                         ///< [Pa]
  /// Displacement that leaves the origin where it is [m].
  Vector2 displacement(double x, double y) const;

private:
  Complex potential(Complex z) const override;
  Complex derivative(Complex z) const override;
  Complex integral(Complex z) const;  ///< of Z, zero in the origin [Pa m]
  Complex root(Complex z) const;      ///< of z^2 - b^2, like z far away, for y >= 0

  double half_width_, peak_pressure_, shear_;
};

}  // namespace dccast::verification
