#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace dccast::statistics {

/// What is known of a quantity over time before it is measured: a nominal trajectory, how much the
/// truth is expected to lie above it, and how these deviations vary together.
struct TrajectoryPrior {
  Eigen::VectorXd time;        ///< (instant) [s] increasing, two or more
  Eigen::VectorXd nominal;     ///< (instant) [unit of the quantity]
  Eigen::VectorXd deviation;   ///< (instant) expected truth minus nominal [unit]
  Eigen::MatrixXd covariance;  ///< (instant, instant) of the deviation [unit^2]
};

/// Members of an ensemble and the runs that show how far its model is off.
struct TrajectoryEnsemble {
  Eigen::VectorXd time;     ///< (instant) [s] increasing, two or more
  Eigen::VectorXd nominal;  ///< (instant) the run with nominal data [unit]
  Eigen::MatrixXd members;  ///< (member, instant) data drawn from their ranges, two or more [unit]
  /// (pair, instant) a finer run minus a member with the same data [unit]; fewer than two pairs
  /// leave the error of the mesh out
  Eigen::MatrixXd misfits;
  double model_error = 0.05;  ///< [1] standard deviation of the model's error, share of the mean
};

/// The prior of an ensemble:
///
///     deviation  = mean(members) - nominal + mean(misfits)
///     covariance = (1 + 1/N) cov(members) + C + model_error^2 m m' k
///
/// m is the mean of the members, k the Matern correlation of smoothness 5/2 over 60 s. C is half
/// the covariance of the misfits and half their variances with an exponential correlation over
/// 60 s, since some twenty pairs do not determine a covariance of hundreds of instants.
/// @throws std::invalid_argument  sizes that do not belong together, or too few members
TrajectoryPrior prior_of(const TrajectoryEnsemble& ensemble);

/// The prior of a quantity of which one nominal run is known alone. The deviation is a random walk
/// along the way of the nominal run: after a reading the last deviation is expected to stay,
/// neither decaying nor growing. At the end its standard deviation is a share of that way:
///
///     covariance(t, s) = share^2 w(end) w(min(t, s))
///
/// w is the sum of |changes of the nominal run|, of which a tenth grows evenly with time, since the
/// truth may move before its nominal run does.
/// @param time     (instant) [s] increasing, two or more
/// @param nominal  (instant) [unit]
/// @throws std::invalid_argument  sizes that do not belong together
TrajectoryPrior random_walk_about(const Eigen::VectorXd& time, const Eigen::VectorXd& nominal,
                                  double share);

/// How a quantity is measured.
struct Gauge {
  double noise = 1.0;  ///< standard deviation of a reading [unit]
  double zero = 0.0;   ///< standard deviation of a constant error of all readings [unit]
};

/// An estimate and its standard deviation [unit].
struct Estimated {
  double value = 0.0;
  double deviation = 0.0;
};

/// Forecasts a quantity from readings by conditioning Gaussian trajectories (Rasmussen and
/// Williams 2006, eq. 2.25 and 2.26, one reading at a time). The unknown zero of the gauge is
/// estimated with them. A reading costs the square of the number of instants. Between instants all
/// is interpolated linearly; before the first and after the last it is that of the end.
class TrajectoryForecast {
public:
  /// @throws std::invalid_argument  sizes that do not belong together
  TrajectoryForecast(const TrajectoryPrior& prior, const Gauge& gauge);

  /// What a gauge is expected to show at a time [s], noise and zero included.
  Estimated expected_reading(double time) const;
  /// Learns from a reading. @param time  [s]  @param value  [unit]
  void learn(double time, double value);
  /// The zero of the gauge has changed: it is less certain by a standard deviation [unit].
  void loosen_zero(double deviation);
  /// The quantity itself at a time [s], given all readings so far.
  Estimated at(double time) const;
  /// The constant error of the gauge, given all readings so far [unit].
  Estimated zero() const;

private:
  /// Weights of the instants around a time, and none of the zero.
  Eigen::SparseVector<double> weights_at(double time) const;
  /// The same with the zero, which a reading has too.
  Eigen::SparseVector<double> reading_weights(double time) const;
  double variance_of(const Eigen::SparseVector<double>& weights) const;

  Eigen::VectorXd time_;  ///< (instant) [s]
  double noise_;          ///< [unit]
  // The quantity at all instants, then the zero of the gauge.
  Eigen::VectorXd mean_;
  Eigen::MatrixXd covariance_;
};

}  // namespace dccast::statistics
