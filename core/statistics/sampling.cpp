#include "core/statistics/sampling.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace dccast::statistics {

namespace {

using Places = std::vector<std::vector<double>>;

constexpr int arrangements = 20;  // to choose from
// With more runs comparing all pairs costs more than it gains.
constexpr int most_compared = 500;

void shuffle(std::vector<int>& order, std::mt19937_64& random) {
  for (std::size_t i = order.size(); i > 1; --i)
    std::swap(order[i - 1], order[static_cast<std::size_t>(random() % i)]);
}

Places arranged(int runs, int axes, std::mt19937_64& random) {
  Places places(static_cast<std::size_t>(runs));
  for (int axis = 0; axis < axes; ++axis) {
    std::vector<int> part(static_cast<std::size_t>(runs));
    std::iota(part.begin(), part.end(), 0);
    shuffle(part, random);
    for (std::size_t i = 0; i < part.size(); ++i)
      places[i].push_back((part[i] + uniform(random)) / runs);
  }
  return places;
}

double square_distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

double closest(const Places& places) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < places.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      least = std::min(least, square_distance(places[i], places[k]));
  return least;
}

}  // namespace

double uniform(std::mt19937_64& random) {
  return (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53;
}

double normal(std::mt19937_64& random) {
  const double radius = std::sqrt(-2.0 * std::log(uniform(random)));
  return radius * std::cos(2.0 * std::numbers::pi * uniform(random));
}

double quantile(const Eigen::VectorXd& sorted, double share) {
  const double at = share * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<Eigen::Index>(at);
  const Eigen::Index above = std::min(below + 1, sorted.size() - 1);
  return sorted(below) + (at - static_cast<double>(below)) * (sorted(above) - sorted(below));
}

std::vector<std::vector<int>> grid(const std::vector<int>& sizes) {
  std::vector<std::vector<int>> runs{{}};
  for (const int size : sizes) {
    std::vector<std::vector<int>> longer;
    for (const auto& run : runs)
      for (int i = 0; i < size; ++i) {
        longer.push_back(run);
        longer.back().push_back(i);
      }
    runs = std::move(longer);
  }
  return runs;
}

Places latin_hypercube(int runs, int axes, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Places best = arranged(runs, axes, random);
  if (runs > most_compared) return best;
  double farthest = closest(best);
  for (int i = 1; i < arrangements; ++i) {
    Places other = arranged(runs, axes, random);
    const double apart = closest(other);
    if (apart <= farthest) continue;
    farthest = apart;
    best = std::move(other);
  }
  return best;
}

Eigen::MatrixXd hypercube(int places, int inputs, std::uint64_t seed) {
  Eigen::MatrixXd matrix(places, inputs);
  const auto rows = latin_hypercube(places, inputs, seed);
  for (int i = 0; i < places; ++i)
    for (int j = 0; j < inputs; ++j)
      matrix(i, j) = rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  return matrix;
}

Eigen::MatrixXd covariance(const Eigen::MatrixXd& draws) {
  const Eigen::MatrixXd centred = draws.rowwise() - draws.colwise().mean();
  return centred.transpose() * centred / static_cast<double>(draws.rows() - 1);
}

}  // namespace dccast::statistics
