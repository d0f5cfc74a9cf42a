#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/statistics/gaussian_process.hpp"

/// Search for designs that perform well for all data, on surfaces that estimate their outcomes.
namespace dccast::statistics {

/// Probability of a yes at places: a Gaussian process over the answers 1 and -1. It is the
/// probability that an error as large as the leave-one-out errors keeps the sign of the mean
/// (least-squares classification, Rasmussen and Williams 2006, section 6.5).
class Classifier {
public:
  /// @param places  (point, input), scaled to 0 to 1; two or more points
  /// @param yes     (point) the answers
  Classifier(const Eigen::MatrixXd& places, const std::vector<bool>& yes);

  /// (place) 0 to 1. If all answers are equal, the same everywhere, by Laplace's rule, and neither
  /// 0 nor 1. @param places  (place, input)
  Eigen::VectorXd probability(const Eigen::MatrixXd& places) const;
  /// (place) estimated answer, 1 for yes, -1 for no, whose error is normal.
  /// @param places  (place, input)
  Eigen::VectorXd answer(const Eigen::MatrixXd& places) const;
  double error() const { return error_; }  ///< standard deviation of the error of an answer
  /// Share of the points that are judged wrongly when they are left out [1].
  double misjudged() const { return misjudged_; }

private:
  std::vector<GaussianProcess> answers_;  ///< empty if all answers are equal
  double uniform_probability_ = 0.5;      ///< used then
  double error_ = 1.0;  ///< root mean square of the leave-one-out errors; 1 if all are equal
  double misjudged_ = 0.0;
};

/// Estimated outcomes, by place: a value that should lie in a band, and a danger.
struct Outcomes {
  Eigen::VectorXd value;   ///< (place) in the unit of the band
  Eigen::VectorXd danger;  ///< (place) probability
  double error = 0.0;      ///< standard deviation of the error of a value
};

/// A design problem. Designs and data are scaled to 0 to 1.
struct DesignProblem {
  int design_inputs = 0;               ///< number of inputs
  double least = 0.0, greatest = 0.0;  ///< limits of the band
  /// Estimates outcomes. @param  (place, design inputs and then data)
  std::function<Outcomes(const Eigen::MatrixXd&)> outcomes;
  std::function<double(const Eigen::RowVectorXd&)> cost;  ///< of a design; to be small
  /// The permitted design nearest to the given one; a permitted design is returned unchanged.
  std::function<Eigen::RowVectorXd(Eigen::RowVectorXd)> permitted;
};

/// Outcomes of a design over the data.
struct DesignScore {
  double low = 0.0, median = 0.0, high = 0.0;  ///< 5, 50, 95 % quantiles of the values
  double danger = 0.0;                         ///< [1] mean probability of the danger
  double risk = 0.0;                           ///< [1] share outside the band or in danger
  double distance = 0.0;                       ///< from the median to the middle of the band
  double cost = 0.0;                           ///< DesignProblem::cost
};

/// A design and its outcomes.
struct ScoredDesign {
  Eigen::RowVectorXd design;  ///< (design input), 0 to 1
  DesignScore score;
};

/// Evaluates a design over given data. @param design  (design input)  @param data  (sample, data
/// input)
DesignScore score_design(const DesignProblem& problem, const Eigen::RowVectorXd& design,
                         const Eigen::MatrixXd& data);

/// Whether `a` is better than `b` in one of the three aims (distance, risk, cost) and worse in
/// none.
bool dominates(const DesignScore& a, const DesignScore& b);

/// The designs that no other design found dominates, least risk first. The search starts from a
/// Latin hypercube and continues with neighbours of the best designs at shrinking distance. It
/// gives the same result on every machine that computes the same outcomes.
/// @param data  (sample, data input) the same for every design, so that their scores differ by the
///              design alone
std::vector<ScoredDesign> pareto_front(const DesignProblem& problem, const Eigen::MatrixXd& data,
                                       std::uint64_t seed);

/// At most `count` designs of a front, least risk first: the one of least risk, then repeatedly the
/// one whose aims are farthest from those already chosen.
/// @param more_risk  designs are eligible if their risk exceeds the least one by at most this
std::vector<ScoredDesign> spread_over(const std::vector<ScoredDesign>& front, std::size_t count,
                                      double more_risk);

/// A share with its standard error.
struct Share {
  double value = 0.0, error = 0.0;  ///< [1]
};

/// The share of castings that are lost, from a model and some castings that were inspected: the
/// model's share plus the mean difference between inspection and model. It is unbiased however
/// wrong the model is (difference estimator; Cochran 1977, section 7.9). The variance of one
/// inspection is at least that of Laplace's rule for no loss among so many.
/// @param modelled  the model's share over all data
/// @param expected  (inspected) the model's probability of a loss  @param lost  what was found
Share corrected_share(double modelled, const Eigen::VectorXd& expected,
                      const std::vector<bool>& lost);

/// (place) probability of being outside the band or in danger, if value and danger are independent
/// at a known place. @param places  (place, design inputs and then data)
Eigen::VectorXd risk_at(const DesignProblem& problem, const Eigen::MatrixXd& places);

}  // namespace dccast::statistics
