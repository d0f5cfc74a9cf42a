#include "core/statistics/sampling.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace dccast::statistics {

namespace {

/// Hypercubes of which the best one is chosen.
constexpr int arrangements = 20;
/// With more places, comparing all pairs costs more than it gains.
constexpr int most_compared = 500;

/// Fisher-Yates shuffle; that of the library differs between libraries.
void shuffle(std::vector<int>& order, std::mt19937_64& random) {
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
}

/// A random Latin hypercube. @return (axis, place), each in (0, 1)
Eigen::MatrixXd random_hypercube(int count, int axes, std::mt19937_64& random) {
  Eigen::MatrixXd places(axes, count);
  std::vector<int> part(count);
  for (int axis = 0; axis < axes; ++axis) {
    std::iota(part.begin(), part.end(), 0);
    shuffle(part, random);
    for (int i = 0; i < count; ++i) places(axis, i) = (part[i] + uniform(random)) / count;
  }
  return places;
}

/// Smallest squared distance between two places. @param places  (axis, place)
double least_squared_distance(const Eigen::MatrixXd& places) {
  double least = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < places.cols(); ++i)
    for (Eigen::Index k = 0; k < i; ++k) {
      double sum = 0.0;  // the same order on every machine, which decides between equal hypercubes
      for (Eigen::Index j = 0; j < places.rows(); ++j)
        sum += (places(j, i) - places(j, k)) * (places(j, i) - places(j, k));
      least = std::min(least, sum);
    }
  return least;
}

}  // namespace

double uniform(std::mt19937_64& random) {
  // The upper 53 bits, moved by half a unit: neither 0 nor 1 can occur.
  return (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53;
}

double normal(std::mt19937_64& random) {
  const double radius = std::sqrt(-2.0 * std::log(uniform(random)));
  return radius * std::cos(2.0 * std::numbers::pi * uniform(random));
}

Eigen::MatrixXd normal_matrix(Eigen::Index rows, Eigen::Index columns, std::mt19937_64& random) {
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); });
}

double normal_below(double x) {
  return 0.5 * std::erfc(-x / std::numbers::sqrt2);
}

double normal_quantile(double share) {
  double low = -9.0, high = 9.0;  // beyond these no share differs from 0 or 1
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (normal_below(middle) < share ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double quantile(const Eigen::VectorXd& sorted, double share) {
  const double position = share * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<Eigen::Index>(position);
  const Eigen::Index above = std::min(below + 1, sorted.size() - 1);
  const double weight = position - static_cast<double>(below);
  return sorted(below) + weight * (sorted(above) - sorted(below));
}

Eigen::MatrixXd hypercube(int places, int axes, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Eigen::MatrixXd best = random_hypercube(places, axes, random);
  if (places > most_compared) return best.transpose();

  double farthest = least_squared_distance(best);
  for (int i = 1; i < arrangements; ++i) {
    Eigen::MatrixXd other = random_hypercube(places, axes, random);
    const double distance = least_squared_distance(other);
    if (distance <= farthest) continue;
    farthest = distance;
    best = std::move(other);
  }
  return best.transpose();
}

std::vector<Eigen::Index> spread_indices(Eigen::Index count, Eigen::Index most) {
  std::vector<Eigen::Index> chosen(std::min(count, most));
  for (Eigen::Index i = 0; i < std::ssize(chosen); ++i) chosen[i] = i * count / std::ssize(chosen);
  return chosen;
}

Eigen::MatrixXd covariance(const Eigen::MatrixXd& draws) {
  const Eigen::MatrixXd centred = draws.rowwise() - draws.colwise().mean();
  return centred.transpose() * centred / static_cast<double>(draws.rows() - 1);
}

}  // namespace dccast::statistics
