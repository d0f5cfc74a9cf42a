#include "core/statistics/trajectory_forecast.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/statistics/gaussian_process.hpp"
#include "core/statistics/sampling.hpp"

namespace dccast::statistics {

namespace {

/// Over which errors of mesh and model are alike [s].
constexpr double memory = 60.0;

void require(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(what);
}

/// exp(-|t - s| / memory).
Eigen::MatrixXd exponential_correlation(const Eigen::VectorXd& time) {
  const Eigen::Index n = time.size();
  Eigen::MatrixXd correlation(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    correlation.col(i) = (-(time.array() - time(i)).abs() / memory).exp();
  return correlation;
}

Eigen::MatrixXd covariance_of_misfit(const TrajectoryEnsemble& ensemble) {
  const Eigen::MatrixXd sample = covariance(ensemble.misfits);
  const Eigen::VectorXd deviation = sample.diagonal().cwiseSqrt();
  const Eigen::MatrixXd smooth =
      deviation.asDiagonal() * exponential_correlation(ensemble.time) * deviation.asDiagonal();
  return 0.5 * sample + 0.5 * smooth;
}

}  // namespace

TrajectoryPrior prior_of(const TrajectoryEnsemble& e) {
  const Eigen::Index instants = e.time.size();
  require(instants >= 2, "a trajectory needs two instants");
  require(e.nominal.size() == instants, "the nominal run has other instants");
  require(e.members.rows() >= 2, "an ensemble needs two members");
  require(e.members.cols() == instants, "the members have other instants");
  require(e.misfits.rows() == 0 || e.misfits.cols() == instants, "the pairs have other instants");

  const Eigen::VectorXd mean = e.members.colwise().mean();
  const double members = static_cast<double>(e.members.rows());
  TrajectoryPrior prior{e.time, e.nominal, mean - e.nominal,
                        (1.0 + 1.0 / members) * covariance(e.members)};

  if (e.misfits.rows() >= 2) {
    prior.deviation += e.misfits.colwise().mean();
    prior.covariance += covariance_of_misfit(e);
  }

  const Eigen::VectorXd error = e.model_error * mean;
  const Eigen::VectorXd length = Eigen::VectorXd::Constant(1, memory);
  prior.covariance += error.asDiagonal() * correlation(e.time, e.time, length) * error.asDiagonal();
  return prior;
}

TrajectoryPrior random_walk_about(const Eigen::VectorXd& time, const Eigen::VectorXd& nominal,
                                  double share) {
  const Eigen::Index instants = time.size();
  require(instants >= 2, "a trajectory needs two instants");
  require(nominal.size() == instants, "the nominal run has other instants");

  Eigen::VectorXd way = Eigen::VectorXd::Zero(instants);
  for (Eigen::Index i = 1; i < instants; ++i)
    way(i) = way(i - 1) + std::abs(nominal(i) - nominal(i - 1));
  constexpr double even = 0.1;
  const double whole = way(instants - 1);
  const Eigen::VectorXd passed = (time.array() - time(0)) / (time(instants - 1) - time(0));
  way = (1.0 - even) * way + even * whole * passed;

  Eigen::MatrixXd covariance(instants, instants);
  for (Eigen::Index i = 0; i < instants; ++i)
    covariance.col(i) = share * share * whole * way.cwiseMin(way(i));
  return {time, nominal, Eigen::VectorXd::Zero(instants), covariance};
}

TrajectoryForecast::TrajectoryForecast(const TrajectoryPrior& prior, const Gauge& gauge)
    : time_(prior.time), noise_(gauge.noise) {
  const Eigen::Index instants = time_.size();
  require(instants >= 2, "a trajectory needs two instants");
  require(prior.nominal.size() == instants, "the nominal run has other instants");
  require(prior.deviation.size() == instants, "the deviation has other instants");
  require(prior.covariance.rows() == instants && prior.covariance.cols() == instants,
          "the covariance has other instants");

  mean_ = Eigen::VectorXd::Zero(instants + 1);
  mean_.head(instants) = prior.nominal + prior.deviation;
  covariance_ = Eigen::MatrixXd::Zero(instants + 1, instants + 1);
  covariance_.topLeftCorner(instants, instants) = prior.covariance;
  covariance_(instants, instants) = gauge.zero * gauge.zero;
}

Eigen::SparseVector<double> TrajectoryForecast::weights_at(double time) const {
  const Eigen::Index last = time_.size() - 1;
  const double within = std::clamp(time, time_(0), time_(last));
  const double* next = std::upper_bound(time_.data(), time_.data() + last, within);
  const Eigen::Index right = std::max<Eigen::Index>(next - time_.data(), 1);
  const double share = (within - time_(right - 1)) / (time_(right) - time_(right - 1));

  Eigen::SparseVector<double> weights(mean_.size());
  weights.insert(right - 1) = 1.0 - share;
  weights.insert(right) = share;
  return weights;
}

Eigen::SparseVector<double> TrajectoryForecast::reading_weights(double time) const {
  Eigen::SparseVector<double> weights = weights_at(time);
  weights.insert(weights.size() - 1) = 1.0;
  return weights;
}

double TrajectoryForecast::variance_of(const Eigen::SparseVector<double>& weights) const {
  return weights.dot(covariance_ * weights);
}

Estimated TrajectoryForecast::expected_reading(double time) const {
  const Eigen::SparseVector<double> weights = reading_weights(time);
  return {weights.dot(mean_), std::sqrt(variance_of(weights) + noise_ * noise_)};
}

void TrajectoryForecast::learn(double time, double value) {
  const Eigen::SparseVector<double> weights = reading_weights(time);
  const Eigen::VectorXd with_reading = covariance_ * weights;
  const double variance = weights.dot(with_reading) + noise_ * noise_;
  if (variance <= 0.0) return;  // the reading was known beforehand
  mean_ += with_reading * ((value - weights.dot(mean_)) / variance);
  covariance_.noalias() -= with_reading * with_reading.transpose() / variance;
}

void TrajectoryForecast::loosen_zero(double deviation) {
  const Eigen::Index zero = mean_.size() - 1;
  covariance_(zero, zero) += deviation * deviation;
}

Estimated TrajectoryForecast::at(double time) const {
  const Eigen::SparseVector<double> weights = weights_at(time);
  return {weights.dot(mean_), std::sqrt(std::max(variance_of(weights), 0.0))};
}

Estimated TrajectoryForecast::zero() const {
  const Eigen::Index last = mean_.size() - 1;
  return {mean_(last), std::sqrt(std::max(covariance_(last, last), 0.0))};
}

}  // namespace dccast::statistics
