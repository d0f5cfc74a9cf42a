#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>
#include <vector>

namespace dccast::statistics {

/// Numbers that are the same with every library, as those of <random> are not.
double uniform(std::mt19937_64& random);  ///< in (0, 1)
double normal(std::mt19937_64& random);   ///< of mean 0 and variance 1 (Box and Muller 1958)

/// The number below which a share of some lies, linear between them. @param sorted  one or more
double quantile(const Eigen::VectorXd& sorted, double share);

/// Every combination of indices below `sizes`, the last axis fastest. (run, axis)
std::vector<std::vector<int>> grid(const std::vector<int>& sizes);

/// Places of a Latin hypercube: each axis is divided into `runs` equal parts, each of which holds
/// one place (McKay, Beckman, Conover 1979). Of some such arrangements the one whose closest places
/// are farthest apart. The same on every machine.
/// @return (run, axis), each in (0, 1)
std::vector<std::vector<double>> latin_hypercube(int runs, int axes, std::uint64_t seed);
/// The same as a matrix, (place, input).
Eigen::MatrixXd hypercube(int places, int inputs, std::uint64_t seed);

/// Covariance of draws. @param draws  (draw, input), two or more
Eigen::MatrixXd covariance(const Eigen::MatrixXd& draws);

}  // namespace dccast::statistics
