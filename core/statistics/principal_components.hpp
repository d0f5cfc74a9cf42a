#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/statistics/gaussian_process.hpp"

namespace dccast::statistics {

/// Surfaces of several figures over a domain of inputs: principal components of the figures, and a
/// Gaussian process over the inputs for the amount of each component.
class PrincipalComponents {
public:
  /// @param places   (point, input), scaled to 0 to 1; two or more points
  /// @param figures  (point, figure), each in its unit; may have no columns
  PrincipalComponents(const Eigen::MatrixXd& places, const Eigen::MatrixXd& figures);

  /// Estimated figures of one place.
  struct Estimate {
    Eigen::VectorXd mean;      ///< (figure) in its unit
    Eigen::VectorXd variance;  ///< (figure) unit squared, bounded below by the leave-one-out error
  };
  /// @param place  (input), scaled to 0 to 1
  Estimate estimate(const Eigen::RowVectorXd& place) const;
  /// (place, figure) the means alone, which cost less than estimate(). @param places  (place,
  /// input)
  Eigen::MatrixXd means(const Eigen::MatrixXd& places) const;
  /// (point) leave-one-out error of one figure, in its unit.
  Eigen::VectorXd left_out_errors(Eigen::Index figure) const;
  /// (place) sum of the variances of some figures, unit squared.
  Eigen::VectorXd summed_variance(const Eigen::MatrixXd& places,
                                  const std::vector<Eigen::Index>& figures) const;

  /// Memory used [bytes].
  std::size_t bytes() const;

private:
  Eigen::RowVectorXd mean_;               ///< (figure)
  Eigen::MatrixXd shape_;                 ///< (figure, component), orthonormal
  Eigen::MatrixXd rest_;                  ///< (point, figure) not represented by the components
  std::vector<GaussianProcess> amounts_;  ///< (component)
  Eigen::VectorXd left_out_;              ///< (figure) mean square of the leave-one-out errors
};

}  // namespace dccast::statistics
