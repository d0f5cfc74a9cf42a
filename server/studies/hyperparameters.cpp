#include "server/studies/hyperparameters.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace dccast::studies {

namespace {

constexpr double shortest = 0.05, longest = 20.0;  // lengths, of a domain of 1
constexpr double least_nugget = 1e-10, most_nugget = 0.3;
constexpr int iterations = 60;
// Few points say little about lengths: without a prior some go to their bounds. One that is a
// factor of e^2 wide leaves every length that the points do speak for as it is.
constexpr double prior_width = 2.0;

Eigen::VectorXd clamped(Eigen::VectorXd parameters) {
  const Eigen::Index inputs = parameters.size() - 1;
  for (Eigen::Index j = 0; j < inputs; ++j)
    parameters(j) = std::clamp(parameters(j), std::log(shortest), std::log(longest));
  parameters(inputs) =
      std::clamp(parameters(inputs), std::log(least_nugget), std::log(most_nugget));
  return parameters;
}

/// Logarithm of the prior and its slope, added.
void add_prior(const Eigen::VectorXd& parameters, Likelihood& likelihood) {
  const Eigen::Index inputs = parameters.size() - 1;
  const Eigen::VectorXd away = parameters.head(inputs) / prior_width;
  likelihood.value -= 0.5 * away.squaredNorm();
  likelihood.gradient.head(inputs) -= away / prior_width;
}

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

}  // namespace

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
  add_prior(parameters, result);
  return result;
}

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

}  // namespace dccast::studies
