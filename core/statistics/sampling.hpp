#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

namespace dccast::statistics {

/// Numbers that are the same with every library, as those of <random> are not.
double uniform(std::mt19937_64& random);  ///< in (0, 1)
double normal(std::mt19937_64& random);   ///< of mean 0 and variance 1 (Box and Muller 1958)

/// Probability that a standard normal number is smaller.
double normal_below(double x);

/// The number below which a share of some lies, linear between them. @param sorted  one or more
double quantile(const Eigen::VectorXd& sorted, double share);

/// Places of a Latin hypercube: each axis is divided into as many equal parts as there are places,
/// each of which holds one (McKay, Beckman, Conover 1979). Of some such arrangements the one whose
/// closest places are farthest apart. The same on every machine.
/// @return (place, axis), each in (0, 1)
Eigen::MatrixXd hypercube(int places, int axes, std::uint64_t seed);

/// Rows of one length, one below the other. @param rows  one or more, of numbers that are
/// contiguous
template <class Row>
Eigen::MatrixXd matrix_of(const std::vector<Row>& rows) {
  Eigen::MatrixXd matrix(rows.size(), rows.front().size());
  for (std::size_t i = 0; i < rows.size(); ++i)
    matrix.row(i) = Eigen::RowVectorXd::Map(rows[i].data(), matrix.cols());
  return matrix;
}

/// Numbers below `all`, spread over them: `most`, or all of them where there are no more.
std::vector<Eigen::Index> spread_indices(Eigen::Index all, Eigen::Index most);

/// Covariance of draws. @param draws  (draw, input), two or more
Eigen::MatrixXd covariance(const Eigen::MatrixXd& draws);

/// A function of independent inputs, each uniform in (0, 1).
/// @param  (place, input)  @return (place, output)
using SampledFunction = std::function<Eigen::MatrixXd(const Eigen::MatrixXd&)>;

/// What share of the variance of a function comes from each of its inputs (Sobol 1993). Where an
/// output does not vary, its indices and their errors are 0.
struct SobolIndices {
  Eigen::MatrixXd first;  ///< (input, output): share of the input alone
  Eigen::MatrixXd total;  ///< (input, output): with its interactions; sum 1 or more
  Eigen::MatrixXd first_error, total_error;  ///< standard errors of the sampling
  Eigen::VectorXd variance;                  ///< by output
};

/// Estimators of Saltelli et al. 2010 for the first order (their table 2, row b) and of Jansen 1999
/// for the total (row f), on independent Latin hypercubes: what their estimates differ by is the
/// error of the sampling. The same on every machine that evaluates the function alike.
/// @param samples  evaluations are this times (inputs + 2), in 32 calls; 64 or more
SobolIndices sobol_indices(const SampledFunction& function, int inputs, int samples,
                           std::uint64_t seed);

}  // namespace dccast::statistics
