#include "server/studies/kernel.hpp"

#include <cmath>

namespace dccast::studies {

namespace {

/// Distances in units of the lengths.
Eigen::MatrixXd distance(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b,
                         const Eigen::VectorXd& length) {
  Eigen::MatrixXd square = Eigen::MatrixXd::Zero(a.rows(), b.rows());
  for (Eigen::Index j = 0; j < a.cols(); ++j)
    for (Eigen::Index k = 0; k < b.rows(); ++k)
      square.col(k).array() += ((a.col(j).array() - b(k, j)) / length(j)).square();
  return square.cwiseSqrt();
}

}  // namespace

Eigen::MatrixXd correlation(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b,
                            const Eigen::VectorXd& length) {
  const Eigen::ArrayXXd scaled = std::sqrt(5.0) * distance(a, b, length).array();
  return (1.0 + scaled + scaled.square() / 3.0) * (-scaled).exp();
}

Eigen::MatrixXd correlation_by_length(const Eigen::MatrixXd& a, const Eigen::VectorXd& length,
                                      Eigen::Index input) {
  const Eigen::ArrayXXd scaled = std::sqrt(5.0) * distance(a, a, length).array();
  Eigen::ArrayXXd along(a.rows(), a.rows());
  for (Eigen::Index k = 0; k < a.rows(); ++k)
    along.col(k) = ((a.col(input).array() - a(k, input)) / length(input)).square();
  return 5.0 / 3.0 * (1.0 + scaled) * (-scaled).exp() * along;
}

}  // namespace dccast::studies
