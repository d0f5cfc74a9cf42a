#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace dccast::statistics {

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

/// A function known at some places, as a Gaussian process with a constant mean and a Matern 5/2
/// correlation (Rasmussen and Williams 2006, chapters 2, 4 and 5).
///
/// Its variance is the one that values left out one by one show, if that is larger than the most
/// likely one: a function that is rougher than the correlation says is less certain than it says
/// (Bachoc 2013, eq. 9).
class GaussianProcess {
public:
  /// @param places  (point, input), scaled to 0 to 1  @param values  (point), two or more
  GaussianProcess(Eigen::MatrixXd places, const Eigen::VectorXd& values);

  struct Estimate {
    Eigen::VectorXd mean;      ///< in the unit of the values
    Eigen::VectorXd variance;  ///< of a value there that was not seen, in its square
  };
  /// @param places  a row each
  Estimate estimate(const Eigen::MatrixXd& places) const;
  /// The means alone.
  Eigen::VectorXd means(const Eigen::MatrixXd& places) const;

  /// Error of the estimate of each value made without it, from one factorisation (eq. 5.12).
  const Eigen::VectorXd& left_out_errors() const { return left_out_errors_; }
  const Hyperparameters& hyperparameters() const { return hyperparameters_; }

private:
  Eigen::MatrixXd places_;
  Hyperparameters hyperparameters_;
  Eigen::LLT<Eigen::MatrixXd> factor_;
  Eigen::VectorXd weights_;       ///< inverse covariance times what is off the mean
  Eigen::VectorXd mean_weights_;  ///< inverse covariance times ones
  Eigen::VectorXd left_out_errors_;
  double mean_ = 0.0;
  double variance_ = 0.0;
};

}  // namespace dccast::statistics
