#include "core/statistics/calibration.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <utility>

#include "core/statistics/gaussian_process.hpp"
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
  }
  result.places = std::move(population.places);
  return result;
}

namespace {

constexpr int draws = 1000;
constexpr double misfit_mean = 0.1;                     // of the scale, before
constexpr double least_noise = 1e-3, most_noise = 0.3;  // of the scale
constexpr double misfit_length = 1.0 / 3.0;             // of the span of the readings
constexpr double variance_before = 1.0 / 12.0;          // of an input
constexpr double fixed_share = 0.25;                    // of the variance before

/// Where the parameters stand in a place: inputs, common error, then two of each quantity.
struct Layout {
  int inputs = 0, quantities = 0;
  int common() const { return inputs; }
  int misfit(int quantity) const { return inputs + 1 + 2 * quantity; }
  int noise(int quantity) const { return misfit(quantity) + 1; }
  int count() const { return inputs + 1 + 2 * quantities; }
};

double misfit_of(double normal, double scale) {
  return -misfit_mean * scale * std::log(std::max(normal_below(-normal), 1e-300));
}

double noise_of(double normal, double scale) {
  return scale * least_noise * std::pow(most_noise / least_noise, normal_below(normal));
}

Eigen::MatrixXd uniform_places(const Eigen::MatrixXd& normal) {
  return normal.unaryExpr([](double value) { return normal_below(value); });
}

Eigen::MatrixXd misfit_shape(const Readings& readings) {
  const Eigen::Index last = readings.at.size() - 1;
  const double span = readings.at(last) - readings.at(0);
  const Eigen::VectorXd length =
      Eigen::VectorXd::Constant(1, span > 0.0 ? misfit_length * span : 1.0);
  return correlation(readings.at, readings.at, length);
}

/// Normal density of what readings are off, up to a constant.
double log_density(const Eigen::VectorXd& off, const Eigen::MatrixXd& covariance) {
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  if (factor.info() != Eigen::Success) return -std::numeric_limits<double>::infinity();
  return -0.5 * factor.matrixL().solve(off).squaredNorm() -
         factor.matrixLLT().diagonal().array().log().sum();
}

}  // namespace

CalibrationDraws calibrate(const CurveModel& model, int inputs,
                           const std::vector<Readings>& readings,
                           const std::vector<Quantity>& quantities, std::uint64_t seed) {
  const Layout layout{inputs, static_cast<int>(quantities.size())};
  std::vector<Eigen::MatrixXd> shapes;
  for (const Readings& curve : readings) shapes.push_back(misfit_shape(curve));
  const auto likelihood = [&](const Eigen::MatrixXd& places) {
    const auto computed = model(uniform_places(places.leftCols(inputs)));
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(places.rows());
    for (std::size_t c = 0; c < readings.size(); ++c) {
      const Readings& curve = readings[c];
      const Quantity& quantity = quantities[curve.quantity];
      for (Eigen::Index i = 0; i < places.rows(); ++i) {
        const double misfit = misfit_of(places(i, layout.misfit(curve.quantity)), quantity.scale);
        const double noise =
            curve.noise.value_or(noise_of(places(i, layout.noise(curve.quantity)), quantity.scale));
        const double factor = 1.0 + quantity.common_error * places(i, layout.common());
        Eigen::MatrixXd covariance = misfit * misfit * shapes[c] + curve.model_covariance;
        covariance.diagonal().array() += noise * noise;
        sum(i) += log_density(curve.values - factor * computed[c].row(i).transpose(), covariance);
      }
    }
    return sum;
  };
  const PosteriorDraws found = draw_posterior(likelihood, layout.count(), draws, seed);
  CalibrationDraws result;
  result.inputs = uniform_places(found.places.leftCols(inputs));
  result.misfit.resize(draws, layout.quantities);
  result.noise.resize(draws, layout.quantities);
  double common = 0.0;
  for (int q = 0; q < layout.quantities; ++q) {
    const Quantity& quantity = quantities[q];
    common = std::max(common, quantity.common_error);
    for (Eigen::Index i = 0; i < draws; ++i) {
      result.misfit(i, q) = misfit_of(found.places(i, layout.misfit(q)), quantity.scale);
      result.noise(i, q) = noise_of(found.places(i, layout.noise(q)), quantity.scale);
    }
  }
  result.common = common * found.places.col(layout.common());
  return result;
}

int fixed_combinations(const Eigen::MatrixXd& inputs) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> parts(statistics::covariance(inputs),
                                                             Eigen::EigenvaluesOnly);
  return static_cast<int>((parts.eigenvalues().array() <= fixed_share * variance_before).count());
}

Eigen::Index central_draw(const Eigen::MatrixXd& inputs) {
  const Eigen::MatrixXd centred = inputs.rowwise() - inputs.colwise().mean();
  Eigen::MatrixXd covariance = statistics::covariance(inputs);
  covariance.diagonal().array() += 1e-12;
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  const Eigen::MatrixXd whitened = factor.matrixL().solve(centred.transpose());
  Eigen::Index central = 0;
  whitened.colwise().squaredNorm().minCoeff(&central);
  return central;
}

std::vector<Eigen::Index> draws_along_ridge(const Eigen::MatrixXd& inputs,
                                            const std::vector<double>& shares) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> parts(statistics::covariance(inputs));
  const Eigen::VectorXd along = inputs * parts.eigenvectors().rightCols<1>();
  std::vector<Eigen::Index> order(along.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](Eigen::Index i) { return along(i); });
  std::vector<Eigen::Index> chosen;
  for (const double share : shares)
    chosen.push_back(
        order[static_cast<std::size_t>(share * static_cast<double>(order.size() - 1))]);
  return chosen;
}

Eigen::MatrixXd correlations(const Eigen::MatrixXd& inputs) {
  const Eigen::MatrixXd covariance = statistics::covariance(inputs);
  const Eigen::VectorXd scale = covariance.diagonal().cwiseSqrt().unaryExpr(
      [](double value) { return value > 0.0 ? 1.0 / value : 0.0; });
  return scale.asDiagonal() * covariance * scale.asDiagonal();
}

}  // namespace dccast::statistics
