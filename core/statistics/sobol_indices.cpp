#include "core/statistics/sobol_indices.hpp"

#include <algorithm>
#include <vector>

#include "core/statistics/sampling.hpp"

namespace dccast::statistics {

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
      sums.row(static_cast<Eigen::Index>(j)) = b.cwiseProduct(mixed[j] - a).colwise().mean();
    return sums;
  }
  Eigen::MatrixXd total() const {
    Eigen::MatrixXd sums(mixed.size(), a.cols());
    for (std::size_t j = 0; j < mixed.size(); ++j)
      sums.row(static_cast<Eigen::Index>(j)) = 0.5 * (mixed[j] - a).cwiseAbs2().colwise().mean();
    return sums;
  }
  /// By output; the values are centred.
  Eigen::RowVectorXd variance() const {
    return 0.5 * (a.cwiseAbs2().colwise().mean() + b.cwiseAbs2().colwise().mean());
  }
};

Replicate sampled(const SampledFunction& function, int inputs, int places, std::uint64_t seed) {
  const auto drawn = latin_hypercube(places, 2 * inputs, seed);
  Eigen::MatrixXd all(places * (inputs + 2), inputs);
  for (int i = 0; i < places; ++i)
    for (int j = 0; j < inputs; ++j) {
      const double a = drawn[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
      const double b = drawn[static_cast<std::size_t>(i)][static_cast<std::size_t>(inputs + j)];
      for (int k = 0; k < inputs; ++k) all(places * (2 + k) + i, j) = k == j ? b : a;
      all(i, j) = a;
      all(places + i, j) = b;
    }
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
  indices.mean = mean.transpose();
  indices.variance = variance.front().transpose();
  for (int r = 1; r < replicates; ++r)
    indices.variance += variance[static_cast<std::size_t>(r)].transpose();
  indices.variance /= replicates;
  return indices;
}

}  // namespace dccast::statistics
