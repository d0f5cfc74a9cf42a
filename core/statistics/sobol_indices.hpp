#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>

namespace dccast::statistics {

/// A function of independent inputs, each uniform in (0, 1).
/// @param  (place, input)  @return (place, output)
using SampledFunction = std::function<Eigen::MatrixXd(const Eigen::MatrixXd&)>;

/// What share of the variance of a function comes from each of its inputs (Sobol 1993). Where an
/// output does not vary, its indices and their errors are 0.
struct SobolIndices {
  Eigen::MatrixXd first;  ///< (input, output): share of the input alone
  Eigen::MatrixXd total;  ///< (input, output): with its interactions; sum 1 or more
  Eigen::MatrixXd first_error, total_error;  ///< standard errors of the sampling
  Eigen::VectorXd mean, variance;            ///< by output
};

/// Estimators of Saltelli et al. 2010 for the first order (their table 2, row b) and of Jansen 1999
/// for the total (row f), on independent Latin hypercubes: what their estimates differ by is the
/// error of the sampling. The same on every machine that evaluates the function alike.
/// @param samples  evaluations are this times (inputs + 2), in 32 calls; 64 or more
SobolIndices sobol_indices(const SampledFunction& function, int inputs, int samples,
                           std::uint64_t seed);

}  // namespace dccast::statistics
