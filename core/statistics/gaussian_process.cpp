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

constexpr double shortest = 0.05, longest = 20.0;  // lengths, relative to the domain
constexpr double least_nugget = 1e-10, most_nugget = 0.3;
constexpr int iterations = 60;  // of one ascent

/// Standard deviation of the prior of the logarithm of a length. Without a prior, few points drive
/// some lengths to their bounds; this one, a factor of e^2 wide, leaves every length that the
/// points determine as it is.
constexpr double prior_width = 2.0;

/// A likelihood costs the cube of the number of points, and is evaluated some hundred times; this
/// many points determine the lengths.
constexpr Eigen::Index most_for_lengths = 120;

/// Correlation matrix of places, and its derivatives by the logarithm of each length.
struct CorrelationSlopes {
  Eigen::MatrixXd value;
  std::vector<Eigen::MatrixXd> by_length;
};

/// Correlation of places with each other. The derivative of the Matern 5/2 correlation by the
/// logarithm of a length is 5/3 (1 + a) exp(-a) times the scaled square along this input.
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

/// Logarithms of lengths and nugget within their bounds.
Eigen::VectorXd clamp_parameters(Eigen::VectorXd parameters) {
  const Eigen::Index inputs = parameters.size() - 1;
  for (Eigen::Index j = 0; j < inputs; ++j)
    parameters(j) = std::clamp(parameters(j), std::log(shortest), std::log(longest));

  parameters(inputs) =
      std::clamp(parameters(inputs), std::log(least_nugget), std::log(most_nugget));
  return parameters;
}

/// Best point of an ascent.
struct Optimum {
  Eigen::VectorXd parameters;
  double value = -std::numeric_limits<double>::infinity();
};

/// Maximises the likelihood from `at` by resilient propagation (Riedmiller and Braun 1993), which
/// needs neither a line search nor a scale of the slopes: only the signs of the slopes count.
Optimum climb(const Eigen::MatrixXd& places, const Eigen::VectorXd& values, Eigen::VectorXd at) {
  Eigen::VectorXd step = Eigen::VectorXd::Constant(at.size(), 0.2);
  Eigen::VectorXd slope_before = Eigen::VectorXd::Zero(at.size());
  Optimum best;
  for (int i = 0; i < iterations && step.maxCoeff() > 1e-3; ++i) {
    const Likelihood here = log_likelihood(places, values, at);
    if (here.value > best.value) best = {at, here.value};

    for (Eigen::Index j = 0; j < at.size(); ++j) {
      const double turn = slope_before(j) * here.gradient(j);
      // Longer steps while the slope keeps its sign, shorter ones after it has changed.
      const double change = turn > 0.0 ? 1.2 : turn < 0.0 ? 0.5 : 1.0;
      step(j) = std::clamp(step(j) * change, 1e-4, 1.0);
      slope_before(j) = turn < 0.0 ? 0.0 : here.gradient(j);

      if (slope_before(j) > 0.0) at(j) += step(j);
      if (slope_before(j) < 0.0) at(j) -= step(j);
    }
    at = clamp_parameters(at);
  }
  return best;
}

/// Lengths and nugget of greatest likelihood, by ascents from several starts.
Hyperparameters most_likely(const Eigen::MatrixXd& places, const Eigen::VectorXd& values) {
  const Eigen::Index inputs = places.cols();
  Optimum best;
  for (const auto& [length, nugget] :
       {std::pair(1.0, 1e-6), std::pair(0.3, 1e-4), std::pair(4.0, 1e-8)}) {
    Eigen::VectorXd start = Eigen::VectorXd::Constant(inputs + 1, std::log(length));
    start(inputs) = std::log(nugget);
    Optimum found = climb(places, values, start);
    if (best.parameters.size() == 0 || found.value > best.value) best = std::move(found);
  }
  if (best.parameters.size() == 0) return {Eigen::VectorXd::Ones(inputs), 1e-6};
  return {best.parameters.head(inputs).array().exp(), std::exp(best.parameters(inputs))};
}

/// Lengths and nugget of a process: values that are all equal have no lengths; of many points some
/// are used, spread over all.
Hyperparameters estimate_hyperparameters(const Eigen::MatrixXd& places,
                                         const Eigen::VectorXd& values) {
  const double range = values.maxCoeff() - values.minCoeff();
  if (!(range > 0.0)) return {Eigen::VectorXd::Ones(places.cols()), 1e-6};
  const auto chosen = spread_indices(places.rows(), most_for_lengths);
  return most_likely(places(chosen, Eigen::all), values(chosen) / range);
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

  // Mean and variance of greatest likelihood (generalised least squares), which leaves a function
  // of the correlation alone.
  const Eigen::MatrixXd inverse = factor.solve(Eigen::MatrixXd::Identity(n, n));
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(n);
  const double mean = ones.dot(inverse * values) / ones.dot(inverse * ones);
  const Eigen::VectorXd centred = values.array() - mean;
  const Eigen::VectorXd weights = inverse * centred;
  const double count = static_cast<double>(n);
  const double variance = std::max(centred.dot(weights) / count, 1e-300);
  const double log_determinant = 2.0 * factor.matrixLLT().diagonal().array().log().sum();
  result.value = -0.5 * (count * std::log(variance) + log_determinant);

  // Derivative of the likelihood (Rasmussen and Williams 2006, eq. 5.9).
  const Eigen::MatrixXd turn = weights * weights.transpose() / variance - inverse;
  for (Eigen::Index j = 0; j < inputs; ++j)
    result.gradient(j) = 0.5 * turn.cwiseProduct(slopes.by_length[std::size_t(j)]).sum();
  result.gradient(inputs) = 0.5 * nugget * turn.trace();

  // Normal prior of the logarithms of the lengths.
  const Eigen::VectorXd away = parameters.head(inputs) / prior_width;
  result.value -= 0.5 * away.squaredNorm();
  result.gradient.head(inputs) -= away / prior_width;
  return result;
}

GaussianProcess::GaussianProcess(Eigen::MatrixXd places, const Eigen::VectorXd& values)
    : places_(std::move(places)), hyperparameters_(estimate_hyperparameters(places_, values)) {
  const Eigen::MatrixXd correlated = correlation(places_, places_, hyperparameters_.length);
  // Round-off can make the matrix of many close places singular: the nugget grows until it is not.
  do {
    Eigen::MatrixXd covariance = correlated;
    covariance.diagonal().array() += hyperparameters_.nugget;
    factor_.compute(covariance);
    if (factor_.info() == Eigen::Success) break;
    hyperparameters_.nugget *= 10.0;
  } while (hyperparameters_.nugget < 1.0);

  // Mean, weights and variance for these lengths.
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(places_.rows());
  mean_weights_ = factor_.solve(ones);
  mean_ = mean_weights_.dot(values) / mean_weights_.sum();
  const Eigen::VectorXd centred = values.array() - mean_;
  weights_ = factor_.solve(centred);
  variance_ = centred.dot(weights_) / static_cast<double>(values.size());

  // Errors of left-out values. The mean is estimated without the value, too, so that its share of
  // the inverse is subtracted.
  const Eigen::Index n = places_.rows();
  const Eigen::MatrixXd root = factor_.matrixL().solve(Eigen::MatrixXd::Identity(n, n));
  const Eigen::VectorXd precision =
      root.colwise().squaredNorm().transpose() - mean_weights_.cwiseAbs2() / mean_weights_.sum();
  left_out_errors_ = weights_.cwiseQuotient(precision);

  // Mean, lengths and nugget are fitted to the same values, which costs degrees of freedom.
  const double free = std::max(1.0, static_cast<double>(n - places_.cols() - 2));
  variance_ = std::max(variance_, left_out_errors_.cwiseAbs2().dot(precision) / free);
}

GaussianProcess::Estimate GaussianProcess::estimate(const Eigen::MatrixXd& places) const {
  const Eigen::MatrixXd cross = correlation(places_, places, hyperparameters_.length);
  Estimate result;
  result.mean = (cross.transpose() * weights_).array() + mean_;

  // The last term of the relative variance is the uncertainty of the estimated mean.
  const Eigen::MatrixXd solved = factor_.matrixL().solve(cross);
  const Eigen::ArrayXd missing = 1.0 - (cross.transpose() * mean_weights_).array();
  const Eigen::ArrayXd known = solved.colwise().squaredNorm().transpose().array();
  const Eigen::ArrayXd relative = 1.0 - known + missing.square() / mean_weights_.sum();
  result.variance = variance_ * (relative.max(0.0) + hyperparameters_.nugget).matrix();
  return result;
}

Eigen::VectorXd GaussianProcess::means(const Eigen::MatrixXd& places) const {
  return ((correlation(places_, places, hyperparameters_.length).transpose() * weights_).array() +
          mean_)
      .matrix();
}

}  // namespace dccast::statistics
