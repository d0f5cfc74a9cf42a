#include "core/mesh/graded_cells.hpp"

#include <cmath>
#include <cstddef>

namespace dccast::mesh {

namespace {

/// Sum of 1 + r + ... + r^(n-1) with r = exp(log_ratio); without cancellation where r is near one.
double geometric_sum(double log_ratio, int terms) {
  return log_ratio == 0.0 ? terms : std::expm1(terms * log_ratio) / std::expm1(log_ratio);
}

}  // namespace

std::vector<double> graded_cells(double length, int cells, double first) {
  // Monotone in the ratio, so bisection on its logarithm cannot miss.
  double low = -3.0, high = 3.0;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (first * geometric_sum(middle, cells) < length ? low : high) = middle;
  }
  const double log_ratio = 0.5 * (low + high);
  std::vector<double> widths;
  const double scale = length / geometric_sum(log_ratio, cells);
  for (int i = 0; i < cells; ++i) widths.push_back(scale * std::exp(log_ratio * i));
  return widths;
}

std::vector<double> ends_of_cells(const std::vector<double>& widths, double length) {
  std::vector<double> at{0.0};
  for (double w : widths) at.push_back(at.back() + w);
  at.back() = length;  // without the rounding of the sum: patches must close
  return at;
}

std::vector<double> refined(const std::vector<double>& at, int refinement) {
  std::vector<double> fine{at.front()};
  for (std::size_t i = 1; i < at.size(); ++i) {
    for (int k = 1; k < refinement; ++k) {
      fine.push_back(at[i - 1] + (at[i] - at[i - 1]) * k / refinement);
    }
    fine.push_back(at[i]);
  }
  return fine;
}

}  // namespace dccast::mesh
