#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace dccast::statistics {

/// Parameters of the correlation of a Gaussian process.
struct Hyperparameters {
  Eigen::VectorXd length;  ///< (input) correlation length, of inputs scaled to 0 to 1
  double nugget = 1e-8;    ///< [1] variance of noise, relative to that of the smooth function
};

/// Matern correlation of smoothness 5/2 (Rasmussen and Williams 2006, eq. 4.17):
/// (1 + a + a^2 / 3) exp(-a), a = sqrt(5) r, r^2 = sum of (difference / length)^2.
/// @param a, b  places, a row each  @return (rows of a, rows of b), 1 for equal places
Eigen::MatrixXd correlation(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b,
                            const Eigen::VectorXd& length);

/// A value of the likelihood and its slope.
struct Likelihood {
  double value = 0.0;        ///< logarithm, for the best mean and variance, with a weak prior
  Eigen::VectorXd gradient;  ///< by the logarithms of the lengths, then of the nugget
};

/// Likelihood of correlation parameters (Rasmussen and Williams 2006, eq. 5.8); minus infinity if
/// the correlation matrix is singular.
/// @param places      (point, input), scaled to 0 to 1
/// @param values      (point)
/// @param parameters  logarithms of the lengths, then of the nugget
Likelihood log_likelihood(const Eigen::MatrixXd& places, const Eigen::VectorXd& values,
                          const Eigen::VectorXd& parameters);

/// A function known at some places: a Gaussian process with a constant mean and a Matern 5/2
/// correlation (Rasmussen and Williams 2006, chapters 2, 4 and 5).
///
/// Its variance is that of the errors of left-out values, if this is larger than the most likely
/// one: a function that is rougher than the correlation assumes is less certain than it suggests
/// (Bachoc 2013, eq. 9).
class GaussianProcess {
public:
  /// @param places  (point, input), scaled to 0 to 1  @param values  (point), two or more
  GaussianProcess(Eigen::MatrixXd places, const Eigen::VectorXd& values);

  /// Estimated values and their uncertainty.
  struct Estimate {
    Eigen::VectorXd mean;      ///< in the unit of the values
    Eigen::VectorXd variance;  ///< of a new value, noise included, in the unit squared
  };
  /// @param places  (place, input), scaled as the points
  Estimate estimate(const Eigen::MatrixXd& places) const;
  /// The means alone, which cost less than estimate().
  Eigen::VectorXd means(const Eigen::MatrixXd& places) const;

  /// (point) error of the estimate of each value without this value (eq. 5.12), in its unit.
  const Eigen::VectorXd& left_out_errors() const { return left_out_errors_; }
  /// Correlation lengths and nugget that were found.
  const Hyperparameters& hyperparameters() const { return hyperparameters_; }

private:
  Eigen::MatrixXd places_;
  Hyperparameters hyperparameters_;
  Eigen::LLT<Eigen::MatrixXd> factor_;
  Eigen::VectorXd weights_;          ///< inverse covariance times the deviations from the mean
  Eigen::VectorXd mean_weights_;     ///< inverse covariance times ones
  Eigen::VectorXd left_out_errors_;  ///< (point) in the unit of the values
  double mean_ = 0.0;
  double variance_ = 0.0;
};

}  // namespace dccast::statistics
