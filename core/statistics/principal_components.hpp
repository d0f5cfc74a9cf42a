#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/statistics/gaussian_process.hpp"

namespace dccast::statistics {

/// Rows of figures over a domain, one row for each place: principal components, and a Gaussian
/// process for the amount of each.
class PrincipalComponents {
public:
  /// @param places  (point, input), scaled to 0 to 1  @param figures  (point, figure)
  PrincipalComponents(const Eigen::MatrixXd& places, const Eigen::MatrixXd& figures);

  struct Estimate {
    Eigen::VectorXd mean;      ///< by figure
    Eigen::VectorXd variance;  ///< by figure, at least what points left out are off
  };
  Estimate estimate(const Eigen::RowVectorXd& place) const;
  /// (place, figure) the means alone.
  Eigen::MatrixXd means(const Eigen::MatrixXd& places) const;
  /// (point) what one figure of each point is off when the point is left out.
  Eigen::VectorXd left_out_errors(Eigen::Index figure) const;
  /// (place) sum of the variances of some figures.
  Eigen::VectorXd variance_of(const Eigen::MatrixXd& places,
                              const std::vector<Eigen::Index>& figures) const;

  /// Of memory.
  std::size_t bytes() const;

private:
  Eigen::RowVectorXd mean_;
  Eigen::MatrixXd shape_;  ///< (figure, component), orthonormal
  Eigen::MatrixXd rest_;   ///< (point, figure), what the components leave
  std::vector<GaussianProcess> amounts_;
  Eigen::VectorXd left_out_;  ///< by figure: mean square of what points left out are off
};

}  // namespace dccast::statistics
