#include "core/statistics/sampling.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace dccast::statistics {

namespace {

constexpr int arrangements = 20;  // to choose from
// With more places comparing all pairs costs more than it gains.
constexpr int most_compared = 500;

void shuffle(std::vector<int>& order, std::mt19937_64& random) {
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
}

/// (axis, place)
Eigen::MatrixXd arranged(int count, int axes, std::mt19937_64& random) {
  Eigen::MatrixXd places(axes, count);
  std::vector<int> part(count);
  for (int axis = 0; axis < axes; ++axis) {
    std::iota(part.begin(), part.end(), 0);
    shuffle(part, random);
    for (int i = 0; i < count; ++i) places(axis, i) = (part[i] + uniform(random)) / count;
  }
  return places;
}

/// Square of the distance between the two places that are closest. @param places  (axis, place)
double closest(const Eigen::MatrixXd& places) {
  double least = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < places.cols(); ++i)
    for (Eigen::Index k = 0; k < i; ++k) {
      double sum = 0.0;  // in this order on every machine, which decides between equals
      for (Eigen::Index j = 0; j < places.rows(); ++j)
        sum += (places(j, i) - places(j, k)) * (places(j, i) - places(j, k));
      least = std::min(least, sum);
    }
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

double normal_below(double x) {
  return 0.5 * std::erfc(-x / std::numbers::sqrt2);
}

double quantile(const Eigen::VectorXd& sorted, double share) {
  const double at = share * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<Eigen::Index>(at);
  const Eigen::Index above = std::min(below + 1, sorted.size() - 1);
  return sorted(below) + (at - static_cast<double>(below)) * (sorted(above) - sorted(below));
}

Eigen::MatrixXd hypercube(int places, int axes, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Eigen::MatrixXd best = arranged(places, axes, random);
  if (places > most_compared) return best.transpose();
  double farthest = closest(best);
  for (int i = 1; i < arrangements; ++i) {
    Eigen::MatrixXd other = arranged(places, axes, random);
    const double apart = closest(other);
    if (apart <= farthest) continue;
    farthest = apart;
    best = std::move(other);
  }
  return best.transpose();
}

std::vector<Eigen::Index> spread_indices(Eigen::Index all, Eigen::Index most) {
  std::vector<Eigen::Index> chosen(std::min(all, most));
  for (Eigen::Index i = 0; i < std::ssize(chosen); ++i) chosen[i] = i * all / std::ssize(chosen);
  return chosen;
}

Eigen::MatrixXd covariance(const Eigen::MatrixXd& draws) {
  const Eigen::MatrixXd centred = draws.rowwise() - draws.colwise().mean();
  return centred.transpose() * centred / static_cast<double>(draws.rows() - 1);
}

namespace {

constexpr int replicates = 32;

/// Values of one replicate: at two independent sets of places, and at the first one with an input
/// taken from the second.
struct Replicate {
  Eigen::MatrixXd a, b;                ///< (place, output)
  std::vector<Eigen::MatrixXd> mixed;  ///< by input

  /// (input, output) contributions to the variance, of the input alone and in all.
  Eigen::MatrixXd first() const {
    Eigen::MatrixXd sums(mixed.size(), a.cols());
    for (std::size_t j = 0; j < mixed.size(); ++j)
      sums.row(j) = b.cwiseProduct(mixed[j] - a).colwise().mean();
    return sums;
  }
  Eigen::MatrixXd total() const {
    Eigen::MatrixXd sums(mixed.size(), a.cols());
    for (std::size_t j = 0; j < mixed.size(); ++j)
      sums.row(j) = 0.5 * (mixed[j] - a).cwiseAbs2().colwise().mean();
    return sums;
  }
  /// By output; the values are centred.
  Eigen::RowVectorXd variance() const {
    return 0.5 * (a.cwiseAbs2().colwise().mean() + b.cwiseAbs2().colwise().mean());
  }
};

Replicate sampled(const SampledFunction& function, int inputs, int places, std::uint64_t seed) {
  const Eigen::MatrixXd drawn = hypercube(places, 2 * inputs, seed);
  Eigen::MatrixXd all = drawn.leftCols(inputs).replicate(inputs + 2, 1);
  all.middleRows(places, places) = drawn.rightCols(inputs);
  for (int k = 0; k < inputs; ++k)
    all.block(places * (2 + k), k, places, 1) = drawn.col(inputs + k);
  const Eigen::MatrixXd values = function(all);
  Replicate replicate{values.topRows(places), values.middleRows(places, places), {}};
  for (int k = 0; k < inputs; ++k)
    replicate.mixed.push_back(values.middleRows(places * (2 + k), places));
  return replicate;
}

/// A ratio of means over replicates, and its standard error by the first order of both.
/// @param tops     by replicate, (input, output)  @param bottoms  by replicate, (output)
void divide(const std::vector<Eigen::MatrixXd>& tops,
            const std::vector<Eigen::RowVectorXd>& bottoms, Eigen::MatrixXd& ratio,
            Eigen::MatrixXd& error) {
  const double count = static_cast<double>(tops.size());
  Eigen::MatrixXd top = tops.front();
  Eigen::RowVectorXd bottom = bottoms.front();
  for (std::size_t r = 1; r < tops.size(); ++r) top += tops[r], bottom += bottoms[r];
  const Eigen::RowVectorXd inverse =
      (bottom.array() > 0.0).select(count / bottom.array(), 0.0).matrix();
  ratio = top / count * inverse.asDiagonal();
  Eigen::MatrixXd squares = Eigen::MatrixXd::Zero(top.rows(), top.cols());
  for (std::size_t r = 0; r < tops.size(); ++r)
    squares += (tops[r] - ratio * bottoms[r].asDiagonal()).cwiseAbs2();
  error = (squares / (count * (count - 1.0))).cwiseSqrt() * inverse.asDiagonal();
}

}  // namespace

SobolIndices sobol_indices(const SampledFunction& function, int inputs, int samples,
                           std::uint64_t seed) {
  const int places = std::max(2, samples / replicates);
  std::vector<Replicate> all;
  Eigen::RowVectorXd mean;
  for (int r = 0; r < replicates; ++r) {
    all.push_back(sampled(function, inputs, places, seed + static_cast<std::uint64_t>(r)));
    const Eigen::RowVectorXd here =
        0.5 * (all.back().a.colwise().mean() + all.back().b.colwise().mean());
    mean = r == 0 ? here : Eigen::RowVectorXd(mean + here);
  }
  mean /= replicates;
  std::vector<Eigen::MatrixXd> first, total;
  std::vector<Eigen::RowVectorXd> variance;
  for (Replicate& replicate : all) {
    // What all values have in common only adds noise to the products.
    replicate.a.rowwise() -= mean;
    replicate.b.rowwise() -= mean;
    for (Eigen::MatrixXd& values : replicate.mixed) values.rowwise() -= mean;
    first.push_back(replicate.first());
    total.push_back(replicate.total());
    variance.push_back(replicate.variance());
  }
  SobolIndices indices;
  divide(first, variance, indices.first, indices.first_error);
  divide(total, variance, indices.total, indices.total_error);
  indices.variance = variance.front().transpose();
  for (int r = 1; r < replicates; ++r) indices.variance += variance[r].transpose();
  indices.variance /= replicates;
  return indices;
}

}  // namespace dccast::statistics
