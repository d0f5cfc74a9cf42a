#pragma once

#include <Eigen/Core>
#include <vector>

namespace dccast::studies {

/// What a Gaussian process is shaped by. Lengths are in the units of scaled inputs, 0 to 1 over the
/// domain.
struct Hyperparameters {
  Eigen::VectorXd length;  ///< by input: how far the function resembles itself
  double nugget =
      1e-8;  ///< variance of what no smooth function explains, over that of the function
};

/// Matern correlation of smoothness 5/2 (Rasmussen and Williams 2006, eq. 4.17):
/// (1 + a + a^2 / 3) exp(-a), a = sqrt(5) r, r^2 = sum of (difference / length)^2.
/// @param a, b  places, a row each  @return (rows of a, rows of b), 1 where they are the same
Eigen::MatrixXd correlation(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b,
                            const Eigen::VectorXd& length);

/// A correlation among places, and its derivatives by the logarithm of each length.
struct CorrelationSlopes {
  Eigen::MatrixXd value;
  std::vector<Eigen::MatrixXd> by_length;
};
CorrelationSlopes correlation_slopes(const Eigen::MatrixXd& a, const Eigen::VectorXd& length);

}  // namespace dccast::studies
