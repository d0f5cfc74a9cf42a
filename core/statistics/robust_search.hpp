#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/statistics/gaussian_process.hpp"

/// Designs that do well whatever the data are, by what surfaces know of their outcomes.
namespace dccast::statistics {

/// The share of yes at places, by a Gaussian process over the answers 1 and -1: the probability
/// that an error as large as that of answers left out one by one leaves the sign of its mean
/// (least-squares classification, Rasmussen and Williams 2006, section 6.5).
class Classifier {
public:
  /// @param places  (point, input), scaled to 0 to 1; two or more  @param yes  by point
  Classifier(const Eigen::MatrixXd& places, const std::vector<bool>& yes);

  /// By place, 0 to 1. Where all answers are the same that of Laplace's rule, nowhere 0 or 1.
  Eigen::VectorXd probability(const Eigen::MatrixXd& places) const;
  /// Share of the points that are judged wrongly when they are left out.
  double misjudged() const { return misjudged_; }

private:
  std::vector<GaussianProcess> answers_;  ///< none where all are the same
  double alike_ = 0.5;                    ///< the probability then
  double error_ = 1.0;                    ///< root mean square of answers left out
  double misjudged_ = 0.0;
};

/// What is known of outcomes, by place: a value that is wanted in a band, and a danger.
struct Outcomes {
  Eigen::VectorXd value;
  Eigen::VectorXd danger;  ///< probability
  double error = 0.0;      ///< standard deviation of what values are off
};

/// A design problem. Designs and data are scaled to 0 to 1; data are uniform and independent.
struct DesignProblem {
  int design_inputs = 0, data_inputs = 0;
  double least = 0.0, greatest = 0.0;  ///< the band
  /// @param  (place, design inputs and then data)
  std::function<Outcomes(const Eigen::MatrixXd&)> outcomes;
  std::function<double(const Eigen::RowVectorXd&)> cost;  ///< of a design, to be small
  /// The permitted design next to one; the same for one that is permitted.
  std::function<Eigen::RowVectorXd(Eigen::RowVectorXd)> permitted;
};

/// What a design leads to over the data.
struct DesignScore {
  double low = 0.0, median = 0.0, high = 0.0;  ///< 5, 50, 95 % of the values
  double danger = 0.0;                         ///< share
  double risk = 0.0;                           ///< share outside the band or in danger
  double distance = 0.0;                       ///< of the median from the middle of the band
  double cost = 0.0;
};

struct ScoredDesign {
  Eigen::RowVectorXd design;
  DesignScore score;
};

/// @param data  (sample, data input)
DesignScore score_of(const DesignProblem& problem, const Eigen::RowVectorXd& design,
                     const Eigen::MatrixXd& data);

/// Whether none of the three aims of `a` (distance, risk, cost) is worse than that of `b`, and one
/// is better.
bool dominates(const DesignScore& a, const DesignScore& b);

/// The designs, least risk first, that no other one found dominates: a Latin hypercube, then
/// neighbours of the best ones at shrinking distance. The same on every machine on which the
/// outcomes are.
/// @param samples  of the data, the same for every design
std::vector<ScoredDesign> pareto_front(const DesignProblem& problem, int samples,
                                       std::uint64_t seed);

/// So many of a front, or all: that of least risk, then those farthest in their aims from those
/// chosen, among the ones that risk at most `more_risk` more. Least risk first.
std::vector<ScoredDesign> spread_over(const std::vector<ScoredDesign>& front, std::size_t count,
                                      double more_risk);

/// A share with its standard error.
struct Share {
  double value = 0.0, error = 0.0;
};

/// The share of castings that are lost, from a model and some that were looked at: the model's
/// share plus what those are off it on the mean. Right on the mean however wrong the model is
/// (difference estimator; Cochran 1977, section 7.9). A looked-at one varies at least as much as
/// Laplace's rule for none of them permits.
/// @param modelled  the model's share over all data
/// @param expected  the model's at each that was looked at  @param lost  what it turned out to be
Share corrected_share(double modelled, const Eigen::VectorXd& expected,
                      const std::vector<bool>& lost);

/// The probability that a place is outside the band or in danger, value and danger independent of
/// each other where the place is known.
Eigen::VectorXd risk_at(const DesignProblem& problem, const Eigen::MatrixXd& places);

}  // namespace dccast::statistics
