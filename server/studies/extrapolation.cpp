#include "server/studies/extrapolation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace dccast::studies {
namespace {

constexpr double safety = 1.25;  // Roache's, of a study of three meshes
constexpr double lowest_order = 0.5, highest_order = 1.0;
// A millionth of what tables show: differences below it are round-off, and their ratio is chance.
constexpr double resolved_m = 1e-9;

std::vector<double> difference(const std::vector<double>& fine, const std::vector<double>& coarse) {
  std::vector<double> result(fine.size());
  for (std::size_t i = 0; i < fine.size(); ++i) result[i] = fine[i] - coarse[i];
  return result;
}

/// The time an instant stands for; 1 where there is but one.
double weight(const std::vector<double>& time_s, std::size_t i) {
  if (time_s.size() < 2) return 1.0;
  return i == 0 ? time_s[1] - time_s[0] : time_s[i] - time_s[i - 1];
}

/// rho of later = rho earlier, by least squares; NaN where there is nothing to fit.
double fitted_ratio(const std::vector<double>& time_s, const std::vector<double>& earlier,
                    const std::vector<double>& later) {
  double product = 0.0, square = 0.0, largest = 0.0;
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    if (!std::isfinite(earlier[i]) || !std::isfinite(later[i])) continue;
    product += weight(time_s, i) * earlier[i] * later[i];
    square += weight(time_s, i) * earlier[i] * earlier[i];
    largest = std::max(largest, std::abs(earlier[i]));
  }
  return largest > resolved_m ? product / square : std::numeric_limits<double>::quiet_NaN();
}

bool are_halved(const std::vector<RefinedCurve>& curves) {
  const std::size_t n = curves.size();
  return n >= 3 && curves[n - 1].refinement == 2 * curves[n - 2].refinement &&
         curves[n - 2].refinement == 2 * curves[n - 3].refinement;
}

CurveLimit without_order(const std::vector<RefinedCurve>& curves) {
  CurveLimit limit;
  limit.value_m = curves.back().value_m;
  double largest = 0.0;
  for (std::size_t i = 0; i < limit.value_m.size(); ++i) {
    for (std::size_t k = curves.size() < 3 ? 1 : curves.size() - 2; k < curves.size(); ++k) {
      const double change = std::abs(curves[k].value_m[i] - curves[k - 1].value_m[i]);
      if (std::isfinite(change)) largest = std::max(largest, change);
    }
    limit.uncertainty_m.push_back(safety * largest);
  }
  return limit;
}

}  // namespace

CurveLimit extrapolate(const std::vector<double>& time_s, const std::vector<RefinedCurve>& curves) {
  if (!are_halved(curves)) return without_order(curves);

  // Differences of successive refinements shrink by the ratio rho, from which the order follows.
  const std::vector<double>& finest = curves.back().value_m;
  const std::vector<double>& before = curves[curves.size() - 2].value_m;
  const std::vector<double> d1 = difference(before, curves[curves.size() - 3].value_m);
  const std::vector<double> d2 = difference(finest, before);
  const double rho = fitted_ratio(time_s, d1, d2);
  if (!(rho > 0.0 && rho < 1.0)) return without_order(curves);

  // Richardson extrapolation; a clamped order keeps an accidental ratio from inflating the error.
  CurveLimit limit;
  limit.order = -std::log2(rho);
  const double c = 1.0 / (std::exp2(std::clamp(*limit.order, lowest_order, highest_order)) - 1.0);

  for (std::size_t i = 0; i < finest.size(); ++i) {
    limit.value_m.push_back(finest[i] + c * rho * d1[i]);
    limit.uncertainty_m.push_back(safety * c * std::max(std::abs(d2[i]), std::abs(rho * d1[i])));
  }
  return limit;
}

}  // namespace dccast::studies
