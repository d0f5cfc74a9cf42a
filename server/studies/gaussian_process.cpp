#include "server/studies/gaussian_process.hpp"

#include <algorithm>
#include <cmath>

#include "server/studies/hyperparameters.hpp"

namespace dccast::studies {

namespace {

// The likelihood costs the cube of the points, a hundred times over; this many settle the lengths.
constexpr Eigen::Index most_for_lengths = 120;

/// Every so-many-th of the rows, spread over all.
Eigen::VectorXi spread(Eigen::Index rows) {
  const Eigen::Index count = std::min(rows, most_for_lengths);
  Eigen::VectorXi chosen(count);
  for (Eigen::Index i = 0; i < count; ++i) chosen(i) = static_cast<int>(i * rows / count);
  return chosen;
}

/// Values that are all the same have no lengths.
Hyperparameters lengths_of(const Eigen::MatrixXd& places, const Eigen::VectorXd& values) {
  const double range = values.maxCoeff() - values.minCoeff();
  if (!(range > 0.0)) return {Eigen::VectorXd::Ones(places.cols()), 1e-6};
  const Eigen::VectorXi chosen = spread(places.rows());
  Eigen::MatrixXd some(chosen.size(), places.cols());
  Eigen::VectorXd scaled(chosen.size());
  for (Eigen::Index i = 0; i < chosen.size(); ++i) {
    some.row(i) = places.row(chosen(i));
    scaled(i) = values(chosen(i)) / range;
  }
  return most_likely(some, scaled);
}

}  // namespace

GaussianProcess::GaussianProcess(Eigen::MatrixXd places, const Eigen::VectorXd& values)
    : places_(std::move(places)), hyperparameters_(lengths_of(places_, values)) {
  const Eigen::MatrixXd correlated = correlation(places_, places_, hyperparameters_.length);
  // Round-off can make many close places singular: more nugget until they are not.
  do {
    Eigen::MatrixXd covariance = correlated;
    covariance.diagonal().array() += hyperparameters_.nugget;
    factor_.compute(covariance);
    if (factor_.info() == Eigen::Success) break;
    hyperparameters_.nugget *= 10.0;
  } while (hyperparameters_.nugget < 1.0);
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(places_.rows());
  mean_weights_ = factor_.solve(ones);
  mean_ = mean_weights_.dot(values) / mean_weights_.sum();
  const Eigen::VectorXd centred = values.array() - mean_;
  weights_ = factor_.solve(centred);
  variance_ = centred.dot(weights_) / static_cast<double>(values.size());
  leave_out_one_by_one();
}

GaussianProcess::Estimate GaussianProcess::estimate(const Eigen::MatrixXd& places) const {
  const Eigen::MatrixXd cross = correlation(places_, places, hyperparameters_.length);
  Estimate result;
  result.mean = (cross.transpose() * weights_).array() + mean_;
  const Eigen::MatrixXd solved = factor_.matrixL().solve(cross);
  // The mean is estimated too, which is the second term.
  const Eigen::ArrayXd missing = 1.0 - (cross.transpose() * mean_weights_).array();
  const Eigen::ArrayXd known = solved.colwise().squaredNorm().transpose().array();
  const Eigen::ArrayXd of_function = 1.0 - known + missing.square() / mean_weights_.sum();
  result.variance = variance_ * (of_function.max(0.0) + hyperparameters_.nugget).matrix();
  return result;
}

void GaussianProcess::leave_out_one_by_one() {
  const Eigen::Index n = places_.rows();
  const Eigen::MatrixXd root = factor_.matrixL().solve(Eigen::MatrixXd::Identity(n, n));
  // The mean is estimated anew without the value: what it takes of the inverse is left out.
  const Eigen::VectorXd precision =
      root.colwise().squaredNorm().transpose() - mean_weights_.cwiseAbs2() / mean_weights_.sum();
  left_out_errors_ = weights_.cwiseQuotient(precision);
  // Mean, lengths and nugget follow the values, too: what they have taken of the errors.
  const double free = std::max(1.0, static_cast<double>(n - places_.cols() - 2));
  variance_ = std::max(variance_, left_out_errors_.cwiseAbs2().dot(precision) / free);
}

}  // namespace dccast::studies
