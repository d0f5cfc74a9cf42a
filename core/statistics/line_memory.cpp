#include "core/statistics/line_memory.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace dccast::statistics {

namespace {

/// All readings of all castings, one after the other.
struct JointReadings {
  std::vector<Eigen::Index> instants;
  std::vector<int> casting;  ///< number of the casting, from 0
  Eigen::VectorXd values;
};

JointReadings readings_of(const std::vector<MeasuredCasting>& castings) {
  JointReadings all;
  for (std::size_t i = 0; i < castings.size(); ++i) {
    const MeasuredCasting& casting = castings[i];
    const auto count = static_cast<Eigen::Index>(casting.instants.size());
    if (casting.values.size() != count || casting.noise.size() != count)
      throw std::invalid_argument("a casting has other readings than instants");

    all.instants.insert(all.instants.end(), casting.instants.begin(), casting.instants.end());
    all.casting.insert(all.casting.end(), casting.instants.size(), static_cast<int>(i));
    all.values.conservativeResize(all.values.size() + count);
    all.values.tail(count) = casting.values;
  }
  return all;
}

/// Correlation of what differs in two castings, by their numbers.
double correlation_between(int a, int b, const BetweenCastings& between) {
  return a == b ? 1.0 : (1.0 - between.scatter) * std::pow(between.kept, std::abs(a - b));
}

/// Covariance of the readings: of the trajectories, and of zeros and noise of their gauges.
Eigen::MatrixXd covariance_of(const JointReadings& readings, const Eigen::MatrixXd& of_joint,
                              const std::vector<MeasuredCasting>& castings,
                              const BetweenCastings& between) {
  const auto& casting = readings.casting;
  Eigen::MatrixXd covariance = of_joint(readings.instants, readings.instants);
  for (Eigen::Index i = 0; i < covariance.rows(); ++i)
    for (Eigen::Index j = 0; j < covariance.cols(); ++j)
      covariance(i, j) *= correlation_between(casting[i], casting[j], between);

  Eigen::Index begin = 0;
  for (const MeasuredCasting& each : castings) {
    const Eigen::Index count = each.values.size();
    auto own = covariance.block(begin, begin, count, count);
    own.array() += each.zero * each.zero;
    own.diagonal() += each.noise.cwiseAbs2();
    begin += count;
  }
  return covariance;
}

}  // namespace

Informed inform(const TrajectoryPrior& joint, Eigen::Index instants,
                const std::vector<MeasuredCasting>& castings, const BetweenCastings& between) {
  const Eigen::VectorXd expected = joint.nominal + joint.deviation;
  if (instants > expected.size() || joint.covariance.rows() != expected.size())
    throw std::invalid_argument("the joint prior has other instants");

  Informed informed{{.time = joint.time.head(instants),
                     .nominal = joint.nominal.head(instants),
                     .deviation = joint.deviation.head(instants),
                     .covariance = joint.covariance.topLeftCorner(instants, instants)}};
  const JointReadings readings = readings_of(castings);
  if (readings.instants.empty()) return informed;

  // What the readings have in common with the next casting.
  const int next = static_cast<int>(castings.size());
  Eigen::MatrixXd shared = joint.covariance(Eigen::seqN(0, instants), readings.instants);
  for (Eigen::Index i = 0; i < shared.cols(); ++i)
    shared.col(i) *= correlation_between(readings.casting[i], next, between);

  const Eigen::LLT<Eigen::MatrixXd> factor(
      covariance_of(readings, joint.covariance, castings, between));
  const Eigen::VectorXd surprise = readings.values - expected(readings.instants);
  const Eigen::VectorXd whitened = factor.matrixL().solve(surprise);
  const Eigen::MatrixXd gain = factor.matrixL().solve(shared.transpose());
  informed.prior.deviation += gain.transpose() * whitened;
  informed.prior.covariance -= gain.transpose() * gain;

  const double log_determinant = 2.0 * factor.matrixLLT().diagonal().array().log().sum();
  informed.log_likelihood =
      -0.5 * (whitened.squaredNorm() + log_determinant +
              static_cast<double>(surprise.size()) * std::log(2.0 * std::numbers::pi));
  return informed;
}

Eigen::VectorXd weights_of(const Eigen::VectorXd& log_likelihood) {
  const Eigen::VectorXd weights = (log_likelihood.array() - log_likelihood.maxCoeff()).exp();
  return weights / weights.sum();
}

TrajectoryPrior mixture_of(const std::vector<Informed>& informed, const Eigen::VectorXd& weights) {
  TrajectoryPrior mixture = informed.front().prior;
  mixture.deviation.setZero();
  for (std::size_t i = 0; i < informed.size(); ++i)
    mixture.deviation += weights(i) * informed[i].prior.deviation;

  // The variance is that within the assumptions and that between their means.
  mixture.covariance.setZero();
  for (std::size_t i = 0; i < informed.size(); ++i) {
    const Eigen::VectorXd off = informed[i].prior.deviation - mixture.deviation;
    mixture.covariance += weights(i) * (informed[i].prior.covariance + off * off.transpose());
  }
  return mixture;
}

}  // namespace dccast::statistics
