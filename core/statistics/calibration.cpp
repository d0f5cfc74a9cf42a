#include "core/statistics/calibration.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/statistics/gaussian_process.hpp"
#include "core/statistics/posterior.hpp"
#include "core/statistics/sampling.hpp"

namespace dccast::statistics {

namespace {

constexpr int draws = 1000;
constexpr double misfit_mean = 0.1;                     // prior, relative to the scale
constexpr double least_noise = 1e-3, most_noise = 0.3;  // prior, relative to the scale
constexpr double misfit_length = 1.0 / 3.0;             // relative to the span of the readings
constexpr double prior_variance = 1.0 / 12.0;           // of an input, uniform in (0, 1)
constexpr double fixed_share = 0.25;                    // of the prior variance

/// Columns of a draw: the inputs, the common error, then misfit and noise of each quantity.
struct Layout {
  int inputs = 0, quantities = 0;
  int common() const { return inputs; }
  int misfit(int quantity) const { return inputs + 1 + 2 * quantity; }
  int noise(int quantity) const { return misfit(quantity) + 1; }
  int count() const { return inputs + 1 + 2 * quantities; }
};

/// Standard deviation with an exponential prior, from a standard normal number.
double misfit_deviation(double normal, double scale) {
  return -misfit_mean * scale * std::log(std::max(normal_below(-normal), 1e-300));
}

/// Standard deviation with a log-uniform prior, from a standard normal number.
double noise_deviation(double normal, double scale) {
  return scale * least_noise * std::pow(most_noise / least_noise, normal_below(normal));
}

/// Uniform numbers in (0, 1) from standard normal ones.
Eigen::MatrixXd uniform_places(const Eigen::MatrixXd& normal) {
  return normal.unaryExpr([](double value) { return normal_below(value); });
}

/// Correlation of the misfit between the readings of a curve.
Eigen::MatrixXd misfit_shape(const Readings& readings) {
  const Eigen::Index last = readings.at.size() - 1;
  const double span = readings.at(last) - readings.at(0);
  const Eigen::VectorXd length =
      Eigen::VectorXd::Constant(1, span > 0.0 ? misfit_length * span : 1.0);
  return correlation(readings.at, readings.at, length);
}

/// Logarithm of the normal density of deviations, up to a constant.
double log_density(const Eigen::VectorXd& deviation, const Eigen::MatrixXd& covariance) {
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  if (factor.info() != Eigen::Success) return -std::numeric_limits<double>::infinity();
  return -0.5 * factor.matrixL().solve(deviation).squaredNorm() -
         factor.matrixLLT().diagonal().array().log().sum();
}

}  // namespace

CalibrationDraws calibrate(const CurveModel& model, int inputs,
                           const std::vector<Readings>& readings,
                           const std::vector<Quantity>& quantities, std::uint64_t seed) {
  const Layout layout{inputs, static_cast<int>(quantities.size())};
  std::vector<Eigen::MatrixXd> shapes;
  for (const Readings& curve : readings) shapes.push_back(misfit_shape(curve));

  // Normal density of every curve about (1 + common) model(inputs), with the covariances of misfit,
  // model and noise added.
  const auto likelihood = [&](const Eigen::MatrixXd& places) {
    const auto computed = model(uniform_places(places.leftCols(inputs)));
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(places.rows());
    for (std::size_t c = 0; c < readings.size(); ++c) {
      const Readings& curve = readings[c];
      const Quantity& quantity = quantities[curve.quantity];
      for (Eigen::Index i = 0; i < places.rows(); ++i) {
        const double misfit =
            misfit_deviation(places(i, layout.misfit(curve.quantity)), quantity.scale);
        const double noise = curve.noise.value_or(
            noise_deviation(places(i, layout.noise(curve.quantity)), quantity.scale));
        const double factor = 1.0 + quantity.common_error * places(i, layout.common());

        Eigen::MatrixXd covariance = misfit * misfit * shapes[c] + curve.model_covariance;
        covariance.diagonal().array() += noise * noise;
        sum(i) += log_density(curve.values - factor * computed[c].row(i).transpose(), covariance);
      }
    }
    return sum;
  };
  const PosteriorDraws found = draw_posterior(likelihood, layout.count(), draws, seed);

  // From normal numbers back to inputs and standard deviations.
  CalibrationDraws result;
  result.inputs = uniform_places(found.places.leftCols(inputs));
  result.misfit.resize(draws, layout.quantities);
  result.noise.resize(draws, layout.quantities);
  double common = 0.0;
  for (int q = 0; q < layout.quantities; ++q) {
    const Quantity& quantity = quantities[q];
    common = std::max(common, quantity.common_error);
    for (Eigen::Index i = 0; i < draws; ++i) {
      result.misfit(i, q) = misfit_deviation(found.places(i, layout.misfit(q)), quantity.scale);
      result.noise(i, q) = noise_deviation(found.places(i, layout.noise(q)), quantity.scale);
    }
  }
  result.common = common * found.places.col(layout.common());
  return result;
}

int fixed_combinations(const Eigen::MatrixXd& inputs) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> parts(statistics::covariance(inputs),
                                                             Eigen::EigenvaluesOnly);
  return static_cast<int>((parts.eigenvalues().array() <= fixed_share * prior_variance).count());
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
