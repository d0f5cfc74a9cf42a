#include "core/statistics/posterior.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include "core/statistics/sampling.hpp"

namespace dccast::statistics {

namespace {

constexpr double share_that_counts = 0.5;
constexpr double forgotten = 0.4, forgotten_at_last = 0.1;  // correlation with where a walk began
constexpr int most_steps = 120;                             // of a walk
constexpr double wanted_acceptance = 0.25;                  // Roberts, Gelman and Gilks 1997
constexpr double least_likely = -1e300;                     // of a place without a likelihood

using Random = std::mt19937_64;

/// (rows, columns) standard normal.
Eigen::MatrixXd normals(Eigen::Index rows, Eigen::Index columns, Random& random) {
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); });
}

/// Draws with the logarithm of their likelihood.
struct Population {
  Eigen::MatrixXd places;
  Eigen::VectorXd likelihood;
};

Eigen::VectorXd evaluated(const LogLikelihood& likelihood, const Eigen::MatrixXd& places) {
  Eigen::VectorXd values = likelihood(places);
  for (double& value : values) value = std::isfinite(value) ? value : least_likely;
  return values;
}

/// Weights of draws when the power grows by `step`, largest 1.
Eigen::ArrayXd weights(const Eigen::VectorXd& likelihood, double step) {
  return (step * (likelihood.array() - likelihood.maxCoeff())).exp();
}

/// The growth of the power that leaves the wanted share of draws.
double next_step(const Eigen::VectorXd& likelihood, double rest) {
  const auto share = [&](double step) {
    const Eigen::ArrayXd w = weights(likelihood, step);
    return w.sum() * w.sum() / (w.square().sum() * static_cast<double>(w.size()));
  };
  if (share(rest) >= share_that_counts) return rest;
  double low = 0.0, high = rest;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (share(middle) >= share_that_counts ? low : high) = middle;
  }
  return low > 0.0 ? low : high;
}

/// Systematic resampling (Kitagawa 1996).
Population resampled(const Population& from, const Eigen::ArrayXd& weight, Random& random) {
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

/// Lower Cholesky factor of the covariance of the draws.
Eigen::MatrixXd spread_of(const Eigen::MatrixXd& places) {
  Eigen::MatrixXd covariance = statistics::covariance(places);
  covariance.diagonal().array() += 1e-12 + 1e-9 * covariance.diagonal().maxCoeff();
  return covariance.llt().matrixL();
}

/// Largest correlation of an input with its value at the beginning.
double remembered(const Eigen::MatrixXd& before, const Eigen::MatrixXd& now) {
  const Eigen::MatrixXd a = before.rowwise() - before.colwise().mean();
  const Eigen::MatrixXd b = now.rowwise() - now.colwise().mean();
  const Eigen::ArrayXd norms =
      (a.colwise().norm().array() * b.colwise().norm().array()).transpose().max(1e-300);
  return ((a.array() * b.array()).colwise().sum().transpose() / norms).maxCoeff();
}

/// One Metropolis step of every draw. @return share of the draws that moved
double step(Population& population, const LogLikelihood& likelihood, double power,
            const Eigen::MatrixXd& factor, Random& random) {
  const Eigen::Index count = population.places.rows();
  const Eigen::MatrixXd proposed =
      population.places + normals(count, factor.cols(), random) * factor.transpose();
  const Eigen::VectorXd there = evaluated(likelihood, proposed);
  int moved = 0;
  for (Eigen::Index i = 0; i < count; ++i) {
    const double prior =
        0.5 * (population.places.row(i).squaredNorm() - proposed.row(i).squaredNorm());
    const double gain = power * (there(i) - population.likelihood(i)) + prior;
    if (std::log(uniform(random)) > gain) continue;
    population.places.row(i) = proposed.row(i);
    population.likelihood(i) = there(i);
    ++moved;
  }
  return static_cast<double>(moved) / static_cast<double>(count);
}

void walk(Population& population, const LogLikelihood& likelihood, double power, double& length,
          Random& random) {
  const Eigen::MatrixXd factor = spread_of(population.places);
  const Eigen::MatrixXd begin = population.places;
  const double enough = power < 1.0 ? forgotten : forgotten_at_last;
  for (int i = 0; i < most_steps && (i < 2 || remembered(begin, population.places) > enough); ++i) {
    const double accepted = step(population, likelihood, power, length * factor, random);
    length = std::clamp(length * std::exp(accepted - wanted_acceptance), 1e-3, 3.0);
  }
}

}  // namespace

PosteriorDraws draw_posterior(const LogLikelihood& likelihood, int inputs, int draws,
                              std::uint64_t seed) {
  Random random(seed);
  Population population;
  population.places = normals(draws, inputs, random);
  population.likelihood = evaluated(likelihood, population.places);
  PosteriorDraws result;
  double power = 0.0, length = 2.38 / std::sqrt(static_cast<double>(inputs));
  while (power < 1.0) {
    const double growth = next_step(population.likelihood, 1.0 - power);
    const Eigen::ArrayXd weight = weights(population.likelihood, growth);
    result.log_evidence += growth * population.likelihood.maxCoeff() + std::log(weight.mean());
    power = growth >= 1.0 - power ? 1.0 : power + growth;
    population = resampled(population, weight, random);
    walk(population, likelihood, power, length, random);
    ++result.stages;
  }
  result.places = std::move(population.places);
  return result;
}

double uniform_place(double normal) {
  return 0.5 * std::erfc(-normal / std::numbers::sqrt2);
}

}  // namespace dccast::statistics
