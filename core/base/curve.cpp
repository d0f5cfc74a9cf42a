#include "core/base/curve.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace dccast {

Curve::Curve(Abscissa abscissa, std::vector<double> at, std::vector<double> value)
    : abscissa_(abscissa), at_(std::move(at)), value_(std::move(value)) {
  if (at_.size() != value_.size())
    throw std::logic_error("Curve: abscissae and ordinates differ in number");
}

double Curve::operator()(double x) const {
  // Written so that no comparison with a NaN leads between points that are not there.
  if (!(x > at_.front())) return value_.front();
  if (!(x < at_.back())) return value_.back();

  const auto right =
      static_cast<std::size_t>(std::upper_bound(at_.begin(), at_.end(), x) - at_.begin());
  const double share = (x - at_[right - 1]) / (at_[right] - at_[right - 1]);
  return value_[right - 1] + share * (value_[right] - value_[right - 1]);
}

double Curve::derivative(double x) const {
  if (!(x >= at_.front()) || !(x < at_.back())) return 0.0;
  const auto right =
      static_cast<std::size_t>(std::upper_bound(at_.begin(), at_.end(), x) - at_.begin());
  return (value_[right] - value_[right - 1]) / (at_[right] - at_[right - 1]);
}

double Curve::integral(double a, double b) const {
  if (b < a) return -integral(b, a);
  // The trapezoidal rule between all points of the table in (a, b) is exact for a piecewise linear
  // table.
  double sum = 0.0;
  double left = a;

  auto next = std::upper_bound(at_.begin(), at_.end(), a);
  while (left < b) {
    const double right = next == at_.end() ? b : std::min(b, *next++);
    sum += 0.5 * ((*this)(left) + (*this)(right)) * (right - left);
    left = right;
  }

  return sum;
}

}  // namespace dccast
