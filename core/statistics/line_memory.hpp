#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/statistics/trajectory_forecast.hpp"

namespace dccast::statistics {

/// What was measured of a quantity in a casting that has ended.
struct MeasuredCasting {
  std::vector<Eigen::Index> instants;  ///< (reading) of the joint prior
  Eigen::VectorXd values;              ///< (reading) [unit of the quantity]
  Eigen::VectorXd noise;               ///< (reading) standard deviation, above 0 [unit]
  double zero = 0.0;  ///< standard deviation of a constant error of all readings [unit]
};

/// How alike the castings on a line are. What differs between two castings that are k castings
/// apart has the correlation (1 - scatter) kept^k.
struct BetweenCastings {
  double scatter = 0.2;  ///< [1] share of the variance that each casting draws anew, 0 to 1
  double kept = 1.0;     ///< [1] how much of the rest stays from one casting to the next, 0 to 1
};

/// What castings have told of the next one.
struct Informed {
  TrajectoryPrior prior;        ///< of the next casting
  double log_likelihood = 0.0;  ///< of all that was measured
};

/// Conditions the next casting on those before it (Rasmussen and Williams 2006, eq. 2.25, 2.26 and
/// 2.30). Of each casting alone the joint prior holds, whatever the scatter.
/// @param joint     trajectories of the same data on several recipes, one after the other: first
/// the
///                  instants of the next casting, then those of earlier recipes in any order
/// @param instants  of the next casting, at the begin of the joint prior
/// @param castings  the oldest first; the next casting follows the last of them
/// @throws std::invalid_argument  sizes that do not belong together
Informed inform(const TrajectoryPrior& joint, Eigen::Index instants,
                const std::vector<MeasuredCasting>& castings, const BetweenCastings& between);

/// Weights that add up to one, in proportion to likelihoods. @param log_likelihood  one or more
Eigen::VectorXd weights_of(const Eigen::VectorXd& log_likelihood);

/// The Gaussian with the mean and covariance of a mixture: of assumptions that were weighed by what
/// castings have told. All have the same nominal trajectory.
/// @param weights  (assumption) as many as `informed`, of sum one
TrajectoryPrior mixture_of(const std::vector<Informed>& informed, const Eigen::VectorXd& weights);

}  // namespace dccast::statistics
