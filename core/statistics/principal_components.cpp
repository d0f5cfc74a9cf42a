#include "core/statistics/principal_components.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>

namespace dccast::statistics {

namespace {

constexpr Eigen::Index most_components = 6;
constexpr double share_left = 1e-6;  // of the sum of squares, which the components may leave out

/// Right singular vectors of a matrix, largest first, that carry all but `share_left` of the sum of
/// squares. They are computed from the eigenvectors of the smaller product of the matrix with
/// itself: that squares the condition number, which the share bounds by 1e6, but a singular value
/// decomposition takes 20 s to compile.
/// @param matrix  (point, figure)  @return (figure, component), orthonormal
Eigen::MatrixXd main_directions(const Eigen::MatrixXd& matrix) {
  const bool by_points = matrix.rows() < matrix.cols();
  Eigen::MatrixXd product;
  if (by_points)
    product = matrix * matrix.transpose();
  else
    product = matrix.transpose() * matrix;

  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> parts(product);
  const Eigen::VectorXd squares = parts.eigenvalues().cwiseMax(0.0).reverse();
  const double whole = squares.sum();

  Eigen::Index count = 0;
  const Eigen::Index most = std::min(most_components, squares.size());
  for (double left = whole; count < most && left > share_left * whole; ++count)
    left -= squares(count);

  const Eigen::MatrixXd vectors = parts.eigenvectors().rowwise().reverse().leftCols(count);
  if (!by_points) return vectors;
  return (matrix.transpose() * vectors).colwise().normalized();
}

}  // namespace

PrincipalComponents::PrincipalComponents(const Eigen::MatrixXd& places,
                                         const Eigen::MatrixXd& figures)
    : mean_(figures.colwise().mean()) {
  rest_ = figures.rowwise() - mean_;
  left_out_ = Eigen::VectorXd::Zero(figures.cols());
  if (figures.cols() == 0) return;

  shape_ = main_directions(rest_);
  const Eigen::MatrixXd amounts = rest_ * shape_;
  rest_ -= amounts * shape_.transpose();
  for (Eigen::Index k = 0; k < shape_.cols(); ++k) amounts_.emplace_back(places, amounts.col(k));

  // Left-out errors bound the variance from below: with few points, a process may find long lengths
  // by chance and underestimate its error between the points.
  Eigen::MatrixXd errors = rest_;
  for (std::size_t k = 0; k < amounts_.size(); ++k)
    errors += amounts_[k].left_out_errors() * shape_.col(k).transpose();
  // Mean, lengths and nugget are fitted to the left-out points, too.
  const double free = std::max(1.0, static_cast<double>(errors.rows() - places.cols() - 2));
  left_out_ = errors.colwise().squaredNorm().transpose() / free;
}

PrincipalComponents::Estimate PrincipalComponents::estimate(const Eigen::RowVectorXd& place) const {
  Estimate result{mean_.transpose(),
                  rest_.colwise().squaredNorm().transpose() / static_cast<double>(rest_.rows())};
  for (std::size_t k = 0; k < amounts_.size(); ++k) {
    const auto amount = amounts_[k].estimate(place);
    const auto shape = shape_.col(k);
    result.mean += amount.mean(0) * shape;
    result.variance += amount.variance(0) * shape.cwiseAbs2();
  }
  result.variance = result.variance.cwiseMax(left_out_);
  return result;
}

Eigen::MatrixXd PrincipalComponents::means(const Eigen::MatrixXd& places) const {
  Eigen::MatrixXd values = mean_.replicate(places.rows(), 1);
  for (std::size_t k = 0; k < amounts_.size(); ++k)
    values += amounts_[k].means(places) * shape_.col(k).transpose();
  return values;
}

Eigen::VectorXd PrincipalComponents::left_out_errors(Eigen::Index figure) const {
  Eigen::VectorXd errors = rest_.col(figure);
  for (std::size_t k = 0; k < amounts_.size(); ++k)
    errors += amounts_[k].left_out_errors() * shape_(figure, k);
  return errors;
}

std::size_t PrincipalComponents::bytes() const {
  const Eigen::Index points = rest_.rows();  // squared in the factor of each process
  return sizeof(double) * (rest_.size() + shape_.size() + points * points * amounts_.size());
}

Eigen::VectorXd PrincipalComponents::summed_variance(
    const Eigen::MatrixXd& places, const std::vector<Eigen::Index>& figures) const {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(places.rows());
  for (std::size_t k = 0; k < amounts_.size(); ++k) {
    double share = 0.0;
    for (const Eigen::Index figure : figures) share += shape_(figure, k) * shape_(figure, k);
    sum += share * amounts_[k].estimate(places).variance;
  }
  return sum;
}

}  // namespace dccast::statistics
