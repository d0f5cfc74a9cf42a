#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>
#include <vector>

namespace dccast::statistics {

// Random numbers that are the same with every library; the distributions of <random> are not.

double uniform(std::mt19937_64& random);  ///< in (0, 1), never 0 or 1
double normal(std::mt19937_64& random);   ///< mean 0, variance 1 (Box and Muller 1958)

/// (rows, columns) such numbers.
Eigen::MatrixXd normal_matrix(Eigen::Index rows, Eigen::Index columns, std::mt19937_64& random);

/// Probability that a standard normal number is smaller than `x`.
double normal_below(double x);
/// The standard normal number below which a share of them lies. @param share  within 0 to 1
double normal_quantile(double share);

/// Quantile of numbers, linear between them.
/// @param sorted  ascending, one or more  @param share  0 to 1
double quantile(const Eigen::VectorXd& sorted, double share);

/// Places of a Latin hypercube: each axis is divided into as many equal parts as there are places,
/// and each part holds one place (McKay, Beckman, Conover 1979). Of 20 such arrangements the one
/// whose closest places are farthest apart. The result is the same on every machine.
/// @return (place, axis), each in (0, 1)
Eigen::MatrixXd hypercube(int places, int axes, std::uint64_t seed);

/// Matrix with the given rows.
/// @param rows  one or more of equal length, each with contiguous numbers
template <class Row>
Eigen::MatrixXd stack_rows(const std::vector<Row>& rows) {
  Eigen::MatrixXd matrix(rows.size(), rows.front().size());
  for (std::size_t i = 0; i < rows.size(); ++i)
    matrix.row(i) = Eigen::RowVectorXd::Map(rows[i].data(), matrix.cols());
  return matrix;
}

/// At most `most` indices below `count`, evenly spread.
std::vector<Eigen::Index> spread_indices(Eigen::Index count, Eigen::Index most);

/// Covariance (input, input) of draws. @param draws  (draw, input), two or more
Eigen::MatrixXd covariance(const Eigen::MatrixXd& draws);

}  // namespace dccast::statistics
