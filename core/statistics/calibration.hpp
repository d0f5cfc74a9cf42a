#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace dccast::statistics {

/// Readings of one quantity at one place: a measured curve.
struct Readings {
  Eigen::VectorXd at;                ///< abscissae, increasing; time, for example
  Eigen::VectorXd values;            ///< (reading) in the unit of the quantity
  Eigen::MatrixXd model_covariance;  ///< (reading, reading) of the model's error, unit squared
  std::optional<double> noise;       ///< standard deviation of a reading; empty: inferred
  int quantity = 0;                  ///< index of the quantity that is measured
};

/// Properties that all curves of a quantity share: they cannot be inferred from one curve alone.
struct Quantity {
  double scale = 1.0;         ///< root mean square of the readings: the unit of noise and misfit
  double common_error = 0.0;  ///< [1] relative standard deviation of the model's common error
};

/// Curves that a model computes.
/// @param  (place, input), 0 to 1  @return by curve (place, reading), in the unit of the readings
using CurveModel = std::function<std::vector<Eigen::MatrixXd>(const Eigen::MatrixXd&)>;

/// Posterior draws of the inputs of a model and of its errors.
struct CalibrationDraws {
  Eigen::MatrixXd inputs;         ///< (draw, input), 0 to 1
  Eigen::VectorXd common;         ///< (draw) the common error [1]
  Eigen::MatrixXd noise, misfit;  ///< (draw, quantity) standard deviations, in its unit
};

/// Infers the inputs of a model, whose prior is independent and uniform in (0, 1), from
///
///     reading = (1 + common) model(inputs) + error of the model + misfit + noise
///
/// The misfit is the part of the readings that the model cannot follow with any inputs: a Gaussian
/// process over `at` with a Matern 5/2 correlation over a third of the readings' span (Kennedy and
/// O'Hagan 2001). The prior of its standard deviation is exponential, a tenth of the scale on
/// average. Noise that is not given is white; the prior of its standard deviation is log-uniform
/// from 0.001 to 0.3 scales.
/// @param readings    one curve or more, at most some 40 readings each: cost grows with their cube
/// @param quantities  by Readings::quantity
/// @return            1000 draws
CalibrationDraws calibrate(const CurveModel& model, int inputs,
                           const std::vector<Readings>& readings,
                           const std::vector<Quantity>& quantities, std::uint64_t seed);

/// Number of independent directions of the inputs that the observations have fixed: those with a
/// quarter or less of their prior variance. @param inputs  (draw, input), 0 to 1
int fixed_combinations(const Eigen::MatrixXd& inputs);

/// Index of the draw nearest to the mean of all draws, by the Mahalanobis distance.
/// @param inputs  (draw, input)
Eigen::Index central_draw(const Eigen::MatrixXd& inputs);

/// Indices of draws along the direction in which the inputs are least known.
/// @param shares  0 to 1: quantiles along this direction  @return one draw for each share
std::vector<Eigen::Index> draws_along_ridge(const Eigen::MatrixXd& inputs,
                                            const std::vector<double>& shares);

/// Correlations (input, input) of draws; 0 for an input that does not vary.
Eigen::MatrixXd correlations(const Eigen::MatrixXd& inputs);

}  // namespace dccast::statistics
