#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace dccast::statistics {

/// Logarithm of a likelihood, up to a constant. @param  (place, input)  @return (place)
using LogLikelihood = std::function<Eigen::VectorXd(const Eigen::MatrixXd&)>;

/// What observations leave of inputs.
struct PosteriorDraws {
  Eigen::MatrixXd places;     ///< (draw, input)
  double log_evidence = 0.0;  ///< logarithm of the mean likelihood before the observations
};

/// Draws from the posterior of inputs that are independent and standard normal before. The
/// likelihood is raised to powers that grow from 0 to 1, each chosen so that half of the draws
/// count; the draws are resampled and moved by random-walk Metropolis steps (Ching and Chen 2007),
/// until their correlation with where they began is small. Finds separate modes, if the prior draws
/// touch them. The same on every machine that evaluates the likelihood alike.
PosteriorDraws draw_posterior(const LogLikelihood& likelihood, int inputs, int draws,
                              std::uint64_t seed);

/// Readings of one quantity at one place.
struct Readings {
  Eigen::VectorXd at;                ///< increasing; time, for example
  Eigen::VectorXd values;            ///< in the unit of the quantity
  Eigen::MatrixXd model_covariance;  ///< (reading, reading) of the model's own error
  std::optional<double> noise;       ///< standard deviation of a reading; empty: inferred
  int quantity = 0;                  ///< that they are of
};

/// What several curves of readings have in common: what cannot be known from one of them.
struct Quantity {
  double scale = 1.0;         ///< root mean square of the readings: the unit of noise and misfit
  double common_error = 0.0;  ///< relative standard deviation of an error of all computed values
};

/// Curves that a model computes. @param  (place, input), 0 to 1  @return by curve (place, reading)
using CurveModel = std::function<std::vector<Eigen::MatrixXd>(const Eigen::MatrixXd&)>;

/// What readings leave of the inputs of a model, and of what the model lacks.
struct CalibrationDraws {
  Eigen::MatrixXd inputs;         ///< (draw, input), 0 to 1
  Eigen::VectorXd common;         ///< (draw) the common error, relative
  Eigen::MatrixXd noise, misfit;  ///< (draw, quantity) standard deviations
};

/// Infers inputs that are independent and uniform in (0, 1) before, from
///
///     reading = (1 + common) model(inputs) + error of the model + misfit + noise
///
/// The misfit is what the model cannot follow whatever its inputs: a Gaussian process over `at`
/// with a Matern 5/2 correlation over a third of the readings' span (Kennedy and O'Hagan 2001),
/// whose standard deviation is exponential before, a tenth of the scale on average. Noise that is
/// not given is white, its standard deviation log-uniform from 0.001 to 0.3 scales.
/// @param readings  one curve or more, at most some 40 readings each: cost grows with their cube
CalibrationDraws calibrate(const CurveModel& model, int inputs,
                           const std::vector<Readings>& readings,
                           const std::vector<Quantity>& quantities, std::uint64_t seed);

/// How many directions of the inputs have a quarter or less of their former variance.
int fixed_combinations(const Eigen::MatrixXd& inputs);

/// The draw next to the mean of all, by the distance that takes their covariance for its unit.
Eigen::Index central_draw(const Eigen::MatrixXd& inputs);

/// Draws along the direction in which the inputs are least known, at these shares of all draws.
std::vector<Eigen::Index> draws_along_ridge(const Eigen::MatrixXd& inputs,
                                            const std::vector<double>& shares);

/// (input, input) of draws; 0 for an input that does not vary.
Eigen::MatrixXd correlations(const Eigen::MatrixXd& inputs);

}  // namespace dccast::statistics
