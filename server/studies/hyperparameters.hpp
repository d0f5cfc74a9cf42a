#pragma once

#include "server/studies/kernel.hpp"

namespace dccast::studies {

/// A value of the likelihood and its slope.
struct Likelihood {
  double value = 0.0;        ///< logarithm, mean and variance at their best, with a weak prior
  Eigen::VectorXd gradient;  ///< by the logarithms of the lengths, then of the nugget
};

/// @param places     (point, input), scaled to 0 to 1
/// @param values     (point)
/// @param parameters  logarithms of the lengths, then of the nugget
Likelihood log_likelihood(const Eigen::MatrixXd& places, const Eigen::VectorXd& values,
                          const Eigen::VectorXd& parameters);

/// Maximises the likelihood from several starts by resilient propagation (Riedmiller and Braun
/// 1993), which needs neither a line search nor a scale of the slopes.
Hyperparameters most_likely(const Eigen::MatrixXd& places, const Eigen::VectorXd& values);

}  // namespace dccast::studies
