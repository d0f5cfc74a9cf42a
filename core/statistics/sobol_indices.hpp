#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>

namespace dccast::statistics {

/// A function of independent inputs, each uniform in (0, 1).
/// @param  (place, input)  @return (place, output)
using SampledFunction = std::function<Eigen::MatrixXd(const Eigen::MatrixXd&)>;

/// Share of the variance of a function that comes from each of its inputs (Sobol 1993). If an
/// output does not vary, its indices and their errors are 0.
struct SobolIndices {
  Eigen::MatrixXd first;  ///< (input, output) share of the input alone
  Eigen::MatrixXd total;  ///< (input, output) share with its interactions; their sum is 1 or more
  Eigen::MatrixXd first_error, total_error;  ///< (input, output) standard errors of the sampling
  Eigen::VectorXd variance;                  ///< (output) in the unit squared
};

/// Estimators of Saltelli et al. 2010 for the first order (their table 2, row b) and of Jansen 1999
/// for the total (row f), on 32 independent Latin hypercubes: the spread of their estimates gives
/// the error of the sampling. The same on every machine that evaluates the function alike.
/// @param inputs   number of inputs
/// @param samples  64 or more; the function is evaluated samples * (inputs + 2) times, in 32 calls
SobolIndices sobol_indices(const SampledFunction& function, int inputs, int samples,
                           std::uint64_t seed);

}  // namespace dccast::statistics
