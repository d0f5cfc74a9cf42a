#include "core/statistics/robust_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "core/statistics/sampling.hpp"

namespace dccast::statistics {

namespace {

constexpr int first_designs = 256;
constexpr int rounds = 8, parents = 24, children = 3;
constexpr double first_step = 0.2, shrinking = 0.7;  // of a neighbour, of a domain of 1

/// Each row of the data at one design.
Eigen::MatrixXd places_of(const Eigen::RowVectorXd& design, const Eigen::MatrixXd& data) {
  Eigen::MatrixXd places(data.rows(), design.size() + data.cols());
  places << design.replicate(data.rows(), 1), data;
  return places;
}

double chance_inside(double value, double error, const DesignProblem& problem) {
  if (!(error > 0.0)) return value >= problem.least && value <= problem.greatest ? 1.0 : 0.0;
  return normal_below((problem.greatest - value) / error) -
         normal_below((problem.least - value) / error);
}

Eigen::VectorXd risks(const DesignProblem& problem, const Outcomes& outcomes) {
  Eigen::VectorXd risk(outcomes.value.size());
  for (Eigen::Index i = 0; i < risk.size(); ++i)
    risk(i) = 1.0 - chance_inside(outcomes.value(i), outcomes.error, problem) *
                        (1.0 - outcomes.danger(i));
  return risk;
}

/// Of a sum of normal distributions about the values: where so much of it lies below.
double quantile(const Outcomes& outcomes, double share) {
  double low = outcomes.value.minCoeff() - 6.0 * outcomes.error;
  double high = outcomes.value.maxCoeff() + 6.0 * outcomes.error;
  const double width = std::max(outcomes.error, 1e-9 * (high - low));
  if (!(width > 0.0)) return low;
  for (int halving = 0; halving < 50; ++halving) {
    const double middle = 0.5 * (low + high);
    double below = 0.0;
    for (const double value : outcomes.value) below += normal_below((middle - value) / width);
    (below < share * static_cast<double>(outcomes.value.size()) ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

bool less_risky(const ScoredDesign& a, const ScoredDesign& b) {
  const DesignScore &s = a.score, &t = b.score;
  return std::tie(s.risk, s.distance, s.cost) < std::tie(t.risk, t.distance, t.cost);
}

std::vector<ScoredDesign> not_dominated(const std::vector<ScoredDesign>& all) {
  std::vector<ScoredDesign> front;
  for (const ScoredDesign& one : all)
    if (std::ranges::none_of(
            all, [&](const ScoredDesign& other) { return dominates(other.score, one.score); }))
      front.push_back(one);
  std::ranges::stable_sort(front, less_risky);
  return front;
}

Eigen::RowVector3d aims_of(const DesignScore& score) {
  return {score.distance, score.risk, score.cost};
}

}  // namespace

Classifier::Classifier(const Eigen::MatrixXd& places, const std::vector<bool>& yes) {
  const auto count = static_cast<double>(yes.size());
  const auto positive = static_cast<double>(std::ranges::count(yes, true));
  alike_ = (positive + 1.0) / (count + 2.0);
  if (positive == 0.0 || positive == count) return;
  Eigen::VectorXd answers(places.rows());
  for (Eigen::Index i = 0; i < answers.size(); ++i) answers(i) = yes[i] ? 1.0 : -1.0;
  answers_.emplace_back(places, answers);
  const Eigen::VectorXd& off = answers_.front().left_out_errors();
  error_ = std::max(0.05, off.norm() / std::sqrt(count));
  // Left out, a point is judged by its answer less what that is off.
  misjudged_ = (answers.cwiseProduct(answers - off).array() < 0.0).cast<double>().mean();
}

Eigen::VectorXd Classifier::probability(const Eigen::MatrixXd& places) const {
  if (answers_.empty()) return Eigen::VectorXd::Constant(places.rows(), alike_);
  return answers_.front().means(places).unaryExpr(
      [this](double mean) { return normal_below(mean / error_); });
}

DesignScore score_of(const DesignProblem& problem, const Eigen::RowVectorXd& design,
                     const Eigen::MatrixXd& data) {
  const Outcomes outcomes = problem.outcomes(places_of(design, data));
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

std::vector<ScoredDesign> pareto_front(const DesignProblem& problem, int samples,
                                       std::uint64_t seed) {
  const Eigen::MatrixXd data = hypercube(samples, problem.data_inputs, seed);
  std::vector<ScoredDesign> all;
  const auto add = [&](const Eigen::RowVectorXd& design) {
    Eigen::RowVectorXd permitted = problem.permitted(design.cwiseMax(0.0).cwiseMin(1.0));
    const DesignScore score = score_of(problem, permitted, data);
    all.push_back({std::move(permitted), score});
  };
  const Eigen::MatrixXd first = hypercube(first_designs, problem.design_inputs, seed + 1);
  for (Eigen::Index i = 0; i < first.rows(); ++i) add(first.row(i));
  double step = first_step;
  for (int round = 0; round < rounds; ++round, step *= shrinking) {
    all = not_dominated(all);
    const auto chosen = spread_over(all, parents, 1.0);
    const Eigen::MatrixXd moves = hypercube(parents * children, problem.design_inputs,
                                            seed + 2 + static_cast<unsigned>(round));
    Eigen::Index move = 0;
    for (const ScoredDesign& parent : chosen)
      for (int child = 0; child < children; ++child)
        add(parent.design + step * (2.0 * moves.row(move++).array() - 1.0).matrix());
  }
  return not_dominated(all);
}

std::vector<ScoredDesign> spread_over(const std::vector<ScoredDesign>& front, std::size_t count,
                                      double more_risk) {
  std::vector<ScoredDesign> near;
  for (const ScoredDesign& one : front)
    if (one.score.risk <= front.front().score.risk + more_risk) near.push_back(one);
  if (near.size() <= count) return near;
  Eigen::RowVector3d low = aims_of(near.front().score), high = low;
  for (const ScoredDesign& one : near) {
    low = low.cwiseMin(aims_of(one.score));
    high = high.cwiseMax(aims_of(one.score));
  }
  const Eigen::RowVector3d width = (high - low).cwiseMax(1e-12);
  std::vector<double> apart(near.size(), std::numeric_limits<double>::infinity());
  std::vector<ScoredDesign> chosen;
  for (std::size_t next = 0; chosen.size() < count;) {
    chosen.push_back(near[next]);
    for (std::size_t i = 0; i < near.size(); ++i)
      apart[i] = std::min(
          apart[i],
          (aims_of(near[i].score) - aims_of(near[next].score)).cwiseQuotient(width).squaredNorm());
    next = std::ranges::max_element(apart) - apart.begin();
  }
  std::ranges::stable_sort(chosen, less_risky);
  return chosen;
}

Share corrected_share(double modelled, const Eigen::VectorXd& expected,
                      const std::vector<bool>& lost) {
  const auto count = static_cast<double>(lost.size());
  if (lost.empty()) return {modelled, std::sqrt(modelled * (1.0 - modelled))};
  Eigen::VectorXd off(expected.size());
  for (Eigen::Index i = 0; i < off.size(); ++i) off(i) = (lost[i] ? 1.0 : 0.0) - expected(i);
  const double mean = off.mean();
  const double rare = 1.0 / (count + 2.0);
  const double variance = std::max((off.array() - mean).square().sum() / std::max(1.0, count - 1.0),
                                   rare * (1.0 - rare));
  return {std::clamp(modelled + mean, 0.0, 1.0), std::sqrt(variance / count)};
}

Eigen::VectorXd risk_at(const DesignProblem& problem, const Eigen::MatrixXd& places) {
  return risks(problem, problem.outcomes(places));
}

}  // namespace dccast::statistics
