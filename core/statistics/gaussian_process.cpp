#include "core/statistics/gaussian_process.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/statistics/sampling.hpp"

namespace dccast::statistics {

namespace {

constexpr double shortest = 0.05, longest = 20.0;  // lengths, of a domain of 1
constexpr double least_nugget = 1e-10, most_nugget = 0.3;
constexpr int iterations = 60;
// Few points say little about lengths: without a prior some go to their bounds. One that is a
// factor of e^2 wide leaves every length that the points do speak for as it is.
constexpr double prior_width = 2.0;
// The likelihood costs the cube of the points, a hundred times over; this many settle the lengths.
constexpr Eigen::Index most_for_lengths = 120;

/// A correlation among places, and its derivatives by the logarithm of each length.
struct CorrelationSlopes {
  Eigen::MatrixXd value;
  std::vector<Eigen::MatrixXd> by_length;
};

CorrelationSlopes correlation_slopes(const Eigen::MatrixXd& a, const Eigen::VectorXd& length) {
  const Eigen::Index n = a.rows();
  std::vector<Eigen::MatrixXd> squares;
  Eigen::MatrixXd square = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index j = 0; j < a.cols(); ++j) {
    Eigen::MatrixXd along(n, n);
    for (Eigen::Index k = 0; k < n; ++k)
      along.col(k) = ((a.col(j).array() - a(k, j)) / length(j)).square();
    square += along;
    squares.push_back(std::move(along));
  }
  const Eigen::ArrayXXd scaled = (5.0 * square.array()).sqrt();
  const Eigen::ArrayXXd decay = (-scaled).exp();
  const Eigen::ArrayXXd slope = 5.0 / 3.0 * (1.0 + scaled) * decay;
  for (Eigen::MatrixXd& along : squares) along.array() *= slope;
  return {(1.0 + scaled + scaled.square() / 3.0) * decay, std::move(squares)};
}

Eigen::VectorXd clamped(Eigen::VectorXd parameters) {
  const Eigen::Index inputs = parameters.size() - 1;
  for (Eigen::Index j = 0; j < inputs; ++j)
    parameters(j) = std::clamp(parameters(j), std::log(shortest), std::log(longest));
  parameters(inputs) =
      std::clamp(parameters(inputs), std::log(least_nugget), std::log(most_nugget));
  return parameters;
}

}  // namespace

Eigen::MatrixXd correlation(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b,
                            const Eigen::VectorXd& length) {
  Eigen::MatrixXd square = Eigen::MatrixXd::Zero(a.rows(), b.rows());
  for (Eigen::Index j = 0; j < a.cols(); ++j)
    for (Eigen::Index k = 0; k < b.rows(); ++k)
      square.col(k).array() += ((a.col(j).array() - b(k, j)) / length(j)).square();
  const Eigen::ArrayXXd scaled = std::sqrt(5.0) * square.cwiseSqrt().array();
  return (1.0 + scaled + scaled.square() / 3.0) * (-scaled).exp();
}

Likelihood log_likelihood(const Eigen::MatrixXd& places, const Eigen::VectorXd& values,
                          const Eigen::VectorXd& parameters) {
  const Eigen::Index n = places.rows(), inputs = places.cols();
  const Eigen::VectorXd length = parameters.head(inputs).array().exp();
  const double nugget = std::exp(parameters(inputs));
  const CorrelationSlopes slopes = correlation_slopes(places, length);
  Eigen::MatrixXd covariance = slopes.value;
  covariance.diagonal().array() += nugget;
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  Likelihood result{-std::numeric_limits<double>::infinity(), Eigen::VectorXd::Zero(inputs + 1)};
  if (factor.info() != Eigen::Success) return result;
  const Eigen::MatrixXd inverse = factor.solve(Eigen::MatrixXd::Identity(n, n));
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(n);
  const double mean = ones.dot(inverse * values) / ones.dot(inverse * ones);
  const Eigen::VectorXd centred = values.array() - mean;
  const Eigen::VectorXd weights = inverse * centred;
  const double count = static_cast<double>(n);
  const double variance = std::max(centred.dot(weights) / count, 1e-300);
  const double log_determinant = 2.0 * factor.matrixLLT().diagonal().array().log().sum();
  result.value = -0.5 * (count * std::log(variance) + log_determinant);
  const Eigen::MatrixXd turn = weights * weights.transpose() / variance - inverse;
  for (Eigen::Index j = 0; j < inputs; ++j)
    result.gradient(j) = 0.5 * turn.cwiseProduct(slopes.by_length[std::size_t(j)]).sum();
  result.gradient(inputs) = 0.5 * nugget * turn.trace();
  const Eigen::VectorXd away = parameters.head(inputs) / prior_width;
  result.value -= 0.5 * away.squaredNorm();
  result.gradient.head(inputs) -= away / prior_width;
  return result;
}

namespace {

struct Found {
  Eigen::VectorXd parameters;
  double value = -std::numeric_limits<double>::infinity();
};

Found climb(const Eigen::MatrixXd& places, const Eigen::VectorXd& values, Eigen::VectorXd at) {
  Eigen::VectorXd step = Eigen::VectorXd::Constant(at.size(), 0.2);
  Eigen::VectorXd before = Eigen::VectorXd::Zero(at.size());
  Found best;
  for (int i = 0; i < iterations && step.maxCoeff() > 1e-3; ++i) {
    const Likelihood here = log_likelihood(places, values, at);
    if (here.value > best.value) best = {at, here.value};
    for (Eigen::Index j = 0; j < at.size(); ++j) {
      const double turn = before(j) * here.gradient(j);
      step(j) = std::clamp(step(j) * (turn > 0.0 ? 1.2 : turn < 0.0 ? 0.5 : 1.0), 1e-4, 1.0);
      before(j) = turn < 0.0 ? 0.0 : here.gradient(j);
      at(j) += before(j) > 0.0 ? step(j) : before(j) < 0.0 ? -step(j) : 0.0;
    }
    at = clamped(at);
  }
  return best;
}

/// Maximises the likelihood from several starts by resilient propagation (Riedmiller and Braun
/// 1993), which needs neither a line search nor a scale of the slopes.
Hyperparameters most_likely(const Eigen::MatrixXd& places, const Eigen::VectorXd& values) {
  const Eigen::Index inputs = places.cols();
  Found best;
  for (const auto& [length, nugget] :
       {std::pair(1.0, 1e-6), std::pair(0.3, 1e-4), std::pair(4.0, 1e-8)}) {
    Eigen::VectorXd start = Eigen::VectorXd::Constant(inputs + 1, std::log(length));
    start(inputs) = std::log(nugget);
    Found found = climb(places, values, start);
    if (best.parameters.size() == 0 || found.value > best.value) best = std::move(found);
  }
  if (best.parameters.size() == 0) return {Eigen::VectorXd::Ones(inputs), 1e-6};
  return {best.parameters.head(inputs).array().exp(), std::exp(best.parameters(inputs))};
}

/// Values that are all the same have no lengths. Of many points some, spread over all.
Hyperparameters lengths_of(const Eigen::MatrixXd& places, const Eigen::VectorXd& values) {
  const double range = values.maxCoeff() - values.minCoeff();
  if (!(range > 0.0)) return {Eigen::VectorXd::Ones(places.cols()), 1e-6};
  const auto chosen = spread_indices(places.rows(), most_for_lengths);
  return most_likely(places(chosen, Eigen::all), values(chosen) / range);
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

Eigen::VectorXd GaussianProcess::means(const Eigen::MatrixXd& places) const {
  return ((correlation(places_, places, hyperparameters_.length).transpose() * weights_).array() +
          mean_)
      .matrix();
}

}  // namespace dccast::statistics
