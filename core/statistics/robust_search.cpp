#include "core/statistics/robust_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "core/statistics/sampling.hpp"

namespace dccast::statistics {

namespace {

constexpr int first_designs = 256;                     // of the Latin hypercube
constexpr int rounds = 8, parents = 24, children = 3;  // neighbours of the best designs
constexpr double first_step = 0.2, shrinking = 0.7;    // of a neighbour, relative to the domain

/// One design combined with each row of the data. @return (sample, design inputs and then data)
Eigen::MatrixXd combine(const Eigen::RowVectorXd& design, const Eigen::MatrixXd& data) {
  Eigen::MatrixXd places(data.rows(), design.size() + data.cols());
  places << design.replicate(data.rows(), 1), data;
  return places;
}

/// Probability that a value with a normal error lies in the band.
double chance_inside(double value, double error, const DesignProblem& problem) {
  if (!(error > 0.0)) return value >= problem.least && value <= problem.greatest ? 1.0 : 0.0;
  return normal_below((problem.greatest - value) / error) -
         normal_below((problem.least - value) / error);
}

/// (place) probability of being outside the band or in danger.
Eigen::VectorXd risks(const DesignProblem& problem, const Outcomes& outcomes) {
  Eigen::VectorXd risk(outcomes.value.size());
  for (Eigen::Index i = 0; i < risk.size(); ++i)
    risk(i) = 1.0 - chance_inside(outcomes.value(i), outcomes.error, problem) *
                        (1.0 - outcomes.danger(i));
  return risk;
}

/// Quantile of a mixture of normal distributions about the values, by bisection.
double quantile(const Outcomes& outcomes, double share) {
  double low = outcomes.value.minCoeff() - 6.0 * outcomes.error;
  double high = outcomes.value.maxCoeff() + 6.0 * outcomes.error;
  const double width = std::max(outcomes.error, 1e-9 * (high - low));
  if (!(width > 0.0)) return low;

  for (int halving = 0; halving < 50; ++halving) {
    const double middle = 0.5 * (low + high);
    double below = 0.0;
    for (const double value : outcomes.value) below += normal_below((middle - value) / width);
    if (below < share * static_cast<double>(outcomes.value.size()))
      low = middle;
    else
      high = middle;
  }
  return 0.5 * (low + high);
}

/// Order of designs: by risk, then by distance, then by cost.
bool less_risky(const ScoredDesign& a, const ScoredDesign& b) {
  const DesignScore &s = a.score, &t = b.score;
  return std::tie(s.risk, s.distance, s.cost) < std::tie(t.risk, t.distance, t.cost);
}

/// The designs that no other design dominates, least risk first.
std::vector<ScoredDesign> remove_dominated(const std::vector<ScoredDesign>& designs) {
  std::vector<ScoredDesign> front;
  for (const ScoredDesign& design : designs) {
    const auto beats = [&](const ScoredDesign& other) {
      return dominates(other.score, design.score);
    };
    if (std::ranges::none_of(designs, beats)) front.push_back(design);
  }
  std::ranges::stable_sort(front, less_risky);
  return front;
}

/// The three aims of a design as a point.
Eigen::RowVector3d aims(const DesignScore& score) {
  return {score.distance, score.risk, score.cost};
}

}  // namespace

Classifier::Classifier(const Eigen::MatrixXd& places, const std::vector<bool>& yes) {
  const auto count = static_cast<double>(yes.size());
  const auto positive = static_cast<double>(std::ranges::count(yes, true));
  // Laplace's rule of succession.
  uniform_probability_ = (positive + 1.0) / (count + 2.0);
  if (positive == 0.0 || positive == count) return;

  Eigen::VectorXd answers(places.rows());
  for (Eigen::Index i = 0; i < answers.size(); ++i) answers(i) = yes[i] ? 1.0 : -1.0;
  answers_.emplace_back(places, answers);

  // A left-out point is judged by its answer minus the error of its estimate.
  const Eigen::VectorXd& error = answers_.front().left_out_errors();
  error_ = std::max(0.05, error.norm() / std::sqrt(count));
  misjudged_ = (answers.cwiseProduct(answers - error).array() < 0.0).cast<double>().mean();
}

Eigen::VectorXd Classifier::answer(const Eigen::MatrixXd& places) const {
  if (answers_.empty())
    return Eigen::VectorXd::Constant(places.rows(), normal_quantile(uniform_probability_));
  return answers_.front().means(places);
}

Eigen::VectorXd Classifier::probability(const Eigen::MatrixXd& places) const {
  return answer(places).unaryExpr([this](double mean) { return normal_below(mean / error_); });
}

DesignScore score_design(const DesignProblem& problem, const Eigen::RowVectorXd& design,
                         const Eigen::MatrixXd& data) {
  const Outcomes outcomes = problem.outcomes(combine(design, data));

  DesignScore score;
  score.low = quantile(outcomes, 0.05);
  score.median = quantile(outcomes, 0.5);
  score.high = quantile(outcomes, 0.95);
  score.danger = outcomes.danger.mean();
  score.risk = risks(problem, outcomes).mean();
  score.distance = std::abs(score.median - 0.5 * (problem.least + problem.greatest));
  score.cost = problem.cost(design);
  return score;
}

bool dominates(const DesignScore& a, const DesignScore& b) {
  if (a.distance > b.distance || a.risk > b.risk || a.cost > b.cost) return false;
  return a.distance < b.distance || a.risk < b.risk || a.cost < b.cost;
}

std::vector<ScoredDesign> pareto_front(const DesignProblem& problem, const Eigen::MatrixXd& data,
                                       std::uint64_t seed) {
  std::vector<ScoredDesign> designs;
  const auto add = [&](const Eigen::RowVectorXd& design) {
    Eigen::RowVectorXd permitted = problem.permitted(design.cwiseMax(0.0).cwiseMin(1.0));
    const DesignScore score = score_design(problem, permitted, data);
    designs.push_back({std::move(permitted), score});
  };

  const Eigen::MatrixXd first = hypercube(first_designs, problem.design_inputs, seed + 1);
  for (Eigen::Index i = 0; i < first.rows(); ++i) add(first.row(i));

  // Neighbours of the best designs, nearer in every round.
  double step = first_step;
  for (int round = 0; round < rounds; ++round) {
    designs = remove_dominated(designs);
    const auto chosen = spread_over(designs, parents, 1.0);

    const Eigen::MatrixXd moves = hypercube(parents * children, problem.design_inputs,
                                            seed + 2 + static_cast<unsigned>(round));
    Eigen::Index move = 0;
    for (const ScoredDesign& parent : chosen)
      for (int child = 0; child < children; ++child)
        add(parent.design + step * (2.0 * moves.row(move++).array() - 1.0).matrix());
    step *= shrinking;
  }
  return remove_dominated(designs);
}

std::vector<ScoredDesign> spread_over(const std::vector<ScoredDesign>& front, std::size_t count,
                                      double more_risk) {
  std::vector<ScoredDesign> eligible;
  for (const ScoredDesign& design : front)
    if (design.score.risk <= front.front().score.risk + more_risk) eligible.push_back(design);
  if (eligible.size() <= count) return eligible;

  // Aims have different units: distances are relative to their ranges.
  Eigen::RowVector3d low = aims(eligible.front().score), high = low;
  for (const ScoredDesign& design : eligible) {
    low = low.cwiseMin(aims(design.score));
    high = high.cwiseMax(aims(design.score));
  }
  const Eigen::RowVector3d width = (high - low).cwiseMax(1e-12);

  // The next design is the one farthest from all designs chosen so far.
  std::vector<double> distance(eligible.size(), std::numeric_limits<double>::infinity());
  std::vector<ScoredDesign> chosen;
  for (std::size_t next = 0; chosen.size() < count;) {
    chosen.push_back(eligible[next]);
    for (std::size_t i = 0; i < eligible.size(); ++i) {
      const Eigen::RowVector3d apart = aims(eligible[i].score) - aims(eligible[next].score);
      distance[i] = std::min(distance[i], apart.cwiseQuotient(width).squaredNorm());
    }
    next = std::ranges::max_element(distance) - distance.begin();
  }

  std::ranges::stable_sort(chosen, less_risky);
  return chosen;
}

Share corrected_share(double modelled, const Eigen::VectorXd& expected,
                      const std::vector<bool>& lost) {
  const auto count = static_cast<double>(lost.size());
  if (lost.empty()) return {modelled, std::sqrt(modelled * (1.0 - modelled))};

  Eigen::VectorXd error(expected.size());
  for (Eigen::Index i = 0; i < error.size(); ++i) error(i) = (lost[i] ? 1.0 : 0.0) - expected(i);
  const double mean = error.mean();

  // The variance of one outcome, at least that of Laplace's rule for none lost of so many.
  const double rare = 1.0 / (count + 2.0);
  const double variance = std::max(
      (error.array() - mean).square().sum() / std::max(1.0, count - 1.0), rare * (1.0 - rare));
  return {std::clamp(modelled + mean, 0.0, 1.0), std::sqrt(variance / count)};
}

Eigen::VectorXd risk_at(const DesignProblem& problem, const Eigen::MatrixXd& places) {
  return risks(problem, problem.outcomes(places));
}

}  // namespace dccast::statistics
