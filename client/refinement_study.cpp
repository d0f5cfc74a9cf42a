#include "client/refinement_study.hpp"

#include <algorithm>
#include <cmath>

namespace dccast::client {

Extrapolation extrapolate(const std::vector<double>& figures) {
  Extrapolation result;
  result.value = figures.back();
  for (std::size_t i = 1; i < figures.size(); ++i) {
    result.uncertainty = std::max(result.uncertainty, std::abs(figures[i] - figures[i - 1]));
  }
  if (figures.size() < 3) return result;
  const double last = figures.back() - figures[figures.size() - 2];
  const double before = figures[figures.size() - 2] - figures[figures.size() - 3];
  if (last == 0.0 && before == 0.0) return result;
  if (last * before <= 0.0 || std::abs(last) >= std::abs(before)) return result;
  constexpr double lowest = 0.5, highest = 2.0, safety = 1.25;
  result.order = std::log2(before / last);
  const double rest = last / (std::exp2(std::clamp(*result.order, lowest, highest)) - 1.0);
  result.value = figures.back() + rest;
  result.uncertainty = safety * std::abs(rest);
  return result;
}

}  // namespace dccast::client
