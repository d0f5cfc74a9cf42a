#include "tests/verification/mechanics/hertz_solution.hpp"

#include <cmath>
#include <numbers>

namespace dccast::verification {

namespace {

using std::numbers::pi;
constexpr std::complex<double> i_unit{0.0, 1.0};

}  // namespace

PlaneStress PressedHalfPlane::stress(double x, double y) const {
  const Complex z{x, y}, at = potential(z), slope = derivative(z);
  const double xx = at.real() - y * slope.imag(), yy = at.real() + y * slope.imag();
  return {{xx, yy, poisson * (xx + yy), -y * slope.real()}};
}

Vector2 PressedHalfPlane::traction(double x, double y, const Vector2& n) const {
  const PlaneStress s = stress(x, y);
  return {s.at(0, 0) * n[0] + s.at(0, 1) * n[1], s.at(1, 0) * n[0] + s.at(1, 1) * n[1]};
}

PointForce::Complex PointForce::potential(Complex z) const {
  return -i_unit * force_ / (pi * z);
}

PointForce::Complex PointForce::derivative(Complex z) const {
  return i_unit * force_ / (pi * z * z);
}

HertzContact::HertzContact(double force, double radius, double young, double poisson_ratio)
    : PressedHalfPlane(poisson_ratio),
      half_width_(
          std::sqrt(4.0 * force * radius * (1.0 - poisson_ratio * poisson_ratio) / (pi * young))),
      peak_pressure_(2.0 * force / (pi * half_width_)),
      shear_(young / (2.0 * (1.0 + poisson_ratio))) {}

double HertzContact::pressure(double x) const {
  const double share = x / half_width_;
  return peak_pressure_ * std::sqrt(std::max(0.0, 1.0 - share * share));
}

HertzContact::Complex HertzContact::root(Complex z) const {
  return std::sqrt(z - half_width_) * std::sqrt(z + half_width_);
}

HertzContact::Complex HertzContact::potential(Complex z) const {
  return -i_unit * peak_pressure_ / half_width_ * (z - root(z));
}

HertzContact::Complex HertzContact::derivative(Complex z) const {
  return -i_unit * peak_pressure_ / half_width_ * (1.0 - z / root(z));
}

HertzContact::Complex HertzContact::integral(Complex z) const {
  const Complex s = root(z);
  const Complex logarithm = std::log((z + s) / (i_unit * half_width_));
  return -i_unit * peak_pressure_ / half_width_ * 0.5 *
         (z * (z - s) + half_width_ * half_width_ * logarithm);
}

Vector2 HertzContact::displacement(double x, double y) const {
  const Complex z{x, y}, at = potential(z), sum = integral(z);
  return {((1.0 - 2.0 * poisson) * sum.real() - y * at.imag()) / (2.0 * shear_),
          (2.0 * (1.0 - poisson) * sum.imag() - y * at.real()) / (2.0 * shear_)};
}

}  // namespace dccast::verification
