#include "core/statistics/posterior.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "core/statistics/sampling.hpp"

namespace dccast::statistics {

namespace {

/// Share of the draws that still count when the power of the likelihood grows.
constexpr double effective_share = 0.5;
/// Correlation with its beginning at which a walk ends, before the last power and at it.
constexpr double forgotten = 0.4, forgotten_at_last = 0.1;
constexpr int most_steps = 120;             // of a walk
constexpr double wanted_acceptance = 0.25;  // Roberts, Gelman and Gilks 1997
constexpr double least_likely = -1e300;     // logarithm, instead of infinity and NaN

using Random = std::mt19937_64;

/// Draws, and the logarithm of the likelihood of each.
struct Population {
  Eigen::MatrixXd places;      ///< (draw, input)
  Eigen::VectorXd likelihood;  ///< (draw)
};

/// The likelihood at places; finite everywhere.
Eigen::VectorXd evaluate(const LogLikelihood& likelihood, const Eigen::MatrixXd& places) {
  Eigen::VectorXd values = likelihood(places);
  for (double& value : values) value = std::isfinite(value) ? value : least_likely;
  return values;
}

/// Weights of draws when the power grows by `step`, scaled to a maximum of 1.
Eigen::ArrayXd weights(const Eigen::VectorXd& likelihood, double step) {
  return (step * (likelihood.array() - likelihood.maxCoeff())).exp();
}

/// The growth of the power that leaves the wanted effective share of draws, by bisection.
/// @param rest  largest growth permitted
double next_step(const Eigen::VectorXd& likelihood, double rest) {
  // Effective sample size relative to the number of draws.
  const auto share = [&](double step) {
    const Eigen::ArrayXd w = weights(likelihood, step);
    return w.sum() * w.sum() / (w.square().sum() * static_cast<double>(w.size()));
  };
  if (share(rest) >= effective_share) return rest;

  double low = 0.0, high = rest;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    if (share(middle) >= effective_share)
      low = middle;
    else
      high = middle;
  }
  return low > 0.0 ? low : high;
}

/// Systematic resampling (Kitagawa 1996): each draw is repeated in proportion to its weight.
Population resample(const Population& from, const Eigen::ArrayXd& weight, Random& random) {
  const Eigen::Index count = weight.size();
  Population to = from;
  const double step = weight.sum() / static_cast<double>(count), begin = uniform(random);

  double sum = weight(0);
  for (Eigen::Index i = 0, k = 0; i < count; ++i) {
    while (sum < (begin + static_cast<double>(i)) * step && k + 1 < count) sum += weight(++k);
    to.places.row(i) = from.places.row(k);
    to.likelihood(i) = from.likelihood(k);
  }
  return to;
}

/// Lower Cholesky factor of the covariance of the draws, slightly enlarged so that it exists.
Eigen::MatrixXd covariance_factor(const Eigen::MatrixXd& places) {
  Eigen::MatrixXd covariance = statistics::covariance(places);
  covariance.diagonal().array() += 1e-12 + 1e-9 * covariance.diagonal().maxCoeff();
  return covariance.llt().matrixL();
}

/// Largest correlation, over the inputs, between two states of the same draws.
double largest_correlation(const Eigen::MatrixXd& before, const Eigen::MatrixXd& now) {
  const Eigen::MatrixXd a = before.rowwise() - before.colwise().mean();
  const Eigen::MatrixXd b = now.rowwise() - now.colwise().mean();
  const Eigen::ArrayXd norms =
      (a.colwise().norm().array() * b.colwise().norm().array()).transpose().max(1e-300);
  return ((a.array() * b.array()).colwise().sum().transpose() / norms).maxCoeff();
}

/// One Metropolis step of every draw. @return share of the draws that moved
double metropolis_step(Population& population, const LogLikelihood& likelihood, double power,
                       const Eigen::MatrixXd& factor, Random& random) {
  const Eigen::Index count = population.places.rows();
  const Eigen::MatrixXd proposed =
      population.places + normal_matrix(count, factor.cols(), random) * factor.transpose();
  const Eigen::VectorXd proposed_likelihood = evaluate(likelihood, proposed);

  int moved = 0;
  for (Eigen::Index i = 0; i < count; ++i) {
    // The prior is standard normal: its logarithm is minus half the square.
    const double prior =
        0.5 * (population.places.row(i).squaredNorm() - proposed.row(i).squaredNorm());
    const double gain = power * (proposed_likelihood(i) - population.likelihood(i)) + prior;

    if (std::log(uniform(random)) > gain) continue;
    population.places.row(i) = proposed.row(i);
    population.likelihood(i) = proposed_likelihood(i);
    ++moved;
  }
  return static_cast<double>(moved) / static_cast<double>(count);
}

/// Number of different rows.
double number_of_different(const Eigen::MatrixXd& places) {
  std::set<std::vector<double>> rows;
  for (Eigen::Index i = 0; i < places.rows(); ++i) {
    const Eigen::RowVectorXd row = places.row(i);
    rows.emplace(row.begin(), row.end());
  }
  return static_cast<double>(rows.size());
}

/// Moves the draws until they have forgotten where they began.
/// @param length  [1] of a step, relative to the spread of the draws; adapted to the acceptance
/// @return        PosteriorDraws::effective
double walk(Population& population, const LogLikelihood& likelihood, double power, double& length,
            Random& random) {
  const Eigen::MatrixXd factor = covariance_factor(population.places);
  const Eigen::MatrixXd begin = population.places;
  const double enough = power < 1.0 ? forgotten : forgotten_at_last;

  for (int i = 0; i < most_steps; ++i) {
    if (i >= 2 && !(largest_correlation(begin, population.places) > enough)) break;
    const double accepted = metropolis_step(population, likelihood, power, length * factor, random);
    length = std::clamp(length * std::exp(accepted - wanted_acceptance), 1e-3, 3.0);
  }

  const auto count = static_cast<double>(begin.rows());
  const double different = number_of_different(begin);
  const double renewed = 1.0 - largest_correlation(begin, population.places);
  return different + std::clamp(renewed, 0.0, 1.0) * (count - different);
}

}  // namespace

PosteriorDraws draw_posterior(const LogLikelihood& likelihood, int inputs, int draws,
                              std::uint64_t seed) {
  Random random(seed);
  Population population;
  population.places = normal_matrix(draws, inputs, random);
  population.likelihood = evaluate(likelihood, population.places);

  PosteriorDraws result;
  double power = 0.0;
  double length = 2.38 / std::sqrt(static_cast<double>(inputs));  // Roberts, Gelman, Gilks 1997
  while (power < 1.0) {
    const double growth = next_step(population.likelihood, 1.0 - power);
    const Eigen::ArrayXd weight = weights(population.likelihood, growth);
    // The evidence is the product of the mean weights of all powers.
    result.log_evidence += growth * population.likelihood.maxCoeff() + std::log(weight.mean());

    power = growth >= 1.0 - power ? 1.0 : power + growth;
    population = resample(population, weight, random);
    result.effective = walk(population, likelihood, power, length, random);
  }

  result.places = std::move(population.places);
  return result;
}

}  // namespace dccast::statistics
