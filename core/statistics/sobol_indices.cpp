#include "core/statistics/sobol_indices.hpp"

#include <algorithm>
#include <vector>

#include "core/statistics/sampling.hpp"

namespace dccast::statistics {

namespace {

constexpr int replicates = 32;

/// Values of one replicate: at two independent sets of places, and at the first set with one input
/// taken from the second set.
struct Replicate {
  Eigen::MatrixXd a, b;                ///< (place, output)
  std::vector<Eigen::MatrixXd> mixed;  ///< by input

  /// (input, output) contribution of the input alone to the variance (Saltelli 2010, table 2, b).
  Eigen::MatrixXd first() const {
    Eigen::MatrixXd sums(mixed.size(), a.cols());
    for (std::size_t j = 0; j < mixed.size(); ++j)
      sums.row(j) = b.cwiseProduct(mixed[j] - a).colwise().mean();
    return sums;
  }
  /// (input, output) contribution with all interactions (Jansen 1999; Saltelli 2010, table 2, f).
  Eigen::MatrixXd total() const {
    Eigen::MatrixXd sums(mixed.size(), a.cols());
    for (std::size_t j = 0; j < mixed.size(); ++j)
      sums.row(j) = 0.5 * (mixed[j] - a).cwiseAbs2().colwise().mean();
    return sums;
  }
  /// (output) variance; the values are centred.
  Eigen::RowVectorXd variance() const {
    return 0.5 * (a.cwiseAbs2().colwise().mean() + b.cwiseAbs2().colwise().mean());
  }
};

/// Evaluates the function once, at all places of a replicate one below the other.
Replicate evaluate_replicate(const SampledFunction& function, int inputs, int places,
                             std::uint64_t seed) {
  const Eigen::MatrixXd drawn = hypercube(places, 2 * inputs, seed);
  Eigen::MatrixXd stacked = drawn.leftCols(inputs).replicate(inputs + 2, 1);
  stacked.middleRows(places, places) = drawn.rightCols(inputs);
  for (int k = 0; k < inputs; ++k)
    stacked.block(places * (2 + k), k, places, 1) = drawn.col(inputs + k);

  const Eigen::MatrixXd values = function(stacked);
  Replicate replicate{values.topRows(places), values.middleRows(places, places), {}};
  for (int k = 0; k < inputs; ++k)
    replicate.mixed.push_back(values.middleRows(places * (2 + k), places));
  return replicate;
}

/// Ratio of the means over replicates, and its standard error to first order.
/// @param tops     by replicate, (input, output)
/// @param bottoms  by replicate, (output)
/// @param ratio    receives (input, output); 0 where the mean of the bottoms is not positive
/// @param error    receives the standard error of the ratio
void divide(const std::vector<Eigen::MatrixXd>& tops,
            const std::vector<Eigen::RowVectorXd>& bottoms, Eigen::MatrixXd& ratio,
            Eigen::MatrixXd& error) {
  const double count = static_cast<double>(tops.size());
  Eigen::MatrixXd top = tops.front();
  Eigen::RowVectorXd bottom = bottoms.front();
  for (std::size_t r = 1; r < tops.size(); ++r) {
    top += tops[r];
    bottom += bottoms[r];
  }

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
  std::vector<Replicate> evaluated;
  Eigen::RowVectorXd mean;
  for (int r = 0; r < replicates; ++r) {
    evaluated.push_back(
        evaluate_replicate(function, inputs, places, seed + static_cast<std::uint64_t>(r)));
    const Replicate& last = evaluated.back();
    const Eigen::RowVectorXd here = 0.5 * (last.a.colwise().mean() + last.b.colwise().mean());
    mean = r == 0 ? here : Eigen::RowVectorXd(mean + here);
  }
  mean /= replicates;

  // The estimators multiply values: a common mean would only add noise to the products.
  std::vector<Eigen::MatrixXd> first, total;
  std::vector<Eigen::RowVectorXd> variance;
  for (Replicate& replicate : evaluated) {
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
