#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "server/studies/kernel.hpp"

namespace dccast::studies {

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

  /// Error of the estimate of each value made without it, from one factorisation (eq. 5.12).
  const Eigen::VectorXd& left_out_errors() const { return left_out_errors_; }
  const Hyperparameters& hyperparameters() const { return hyperparameters_; }

private:
  void leave_out_one_by_one();

  Eigen::MatrixXd places_;
  Hyperparameters hyperparameters_;
  Eigen::LLT<Eigen::MatrixXd> factor_;
  Eigen::VectorXd weights_;       ///< inverse covariance times what is off the mean
  Eigen::VectorXd mean_weights_;  ///< inverse covariance times ones
  Eigen::VectorXd left_out_errors_;
  double mean_ = 0.0;
  double variance_ = 0.0;
};

}  // namespace dccast::studies
