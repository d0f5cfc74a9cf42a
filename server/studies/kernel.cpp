#include "server/studies/kernel.hpp"

#include <cmath>
#include <utility>

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

CorrelationSlopes correlation_slopes(const Eigen::MatrixXd& a, const Eigen::VectorXd& length) {
  const Eigen::Index n = a.rows();
  std::vector<Eigen::MatrixXd> squares;
  Eigen::MatrixXd square = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index j = 0; j < a.cols(); ++j) {
    Eigen::MatrixXd along(n, n);
    for (Eigen::Index k = 0; k < n; ++k)
      along.col(k) = ((a.col(j).array() - a(k, j)) / length(j)).square();
    square += along;
    squares.push_back(std::move(along));
  }
  const Eigen::ArrayXXd scaled = (5.0 * square.array()).sqrt();
  const Eigen::ArrayXXd decay = (-scaled).exp();
  const Eigen::ArrayXXd slope = 5.0 / 3.0 * (1.0 + scaled) * decay;
  for (Eigen::MatrixXd& along : squares) along.array() *= slope;
  return {(1.0 + scaled + scaled.square() / 3.0) * decay, std::move(squares)};
}

}  // namespace dccast::studies
