#include "server/studies/next_opening.hpp"

#include <algorithm>
#include <cmath>

#include "proto/values/interpolation.hpp"

namespace dccast::studies {

namespace {

constexpr int places = 61;  // along the face, at which trials are compared
// A run is worth its time when what is known promises a slab nearer to flat by a tenth.
constexpr double worth_a_run = 0.9;
// The share of a change that contraction eats, so that a correction is at least half and at most
// twice what a slab lacks.
constexpr double least_share = -1.0, most_share = 0.5;

/// Places that all trials have.
std::vector<double> common_places(const std::vector<MouldTrial>& history) {
  double end = history.front().x.back();
  for (const MouldTrial& trial : history) end = std::min(end, trial.x.back());
  std::vector<double> x;
  for (int i = 0; i + 1 < places; ++i) x.push_back(end * i / (places - 1));
  x.push_back(end);
  return x;
}

MouldTrial sampled(const MouldTrial& trial, const std::vector<double>& x) {
  return {x, values::at_instants(x, trial.x, trial.opening),
          values::at_instants(x, trial.x, trial.cold)};
}

/// What one trial to the next tells of the share, as the sums of a least-squares fit.
void add_change(const MouldTrial& from, const MouldTrial& to, double& product, double& square) {
  for (std::size_t i = 0; i < from.x.size(); ++i) {
    const double opening = to.opening[i] - from.opening[i];
    const double contraction = opening - (to.cold[i] - from.cold[i]);
    product += contraction * opening;
    square += opening * opening;
  }
}

double eaten_share(const std::vector<MouldTrial>& trials) {
  double product = 0.0, square = 0.0;
  for (std::size_t i = 0; i + 1 < trials.size(); ++i)
    add_change(trials[i], trials[i + 1], product, square);
  return square == 0.0 ? 0.0 : std::clamp(product / square, least_share, most_share);
}

/// The slab that an opening gives, if it follows changes of the best trial's by this share.
MouldTrial predicted(const MouldTrial& best, const MouldOpening& opening, double followed) {
  MouldTrial slab = best;
  for (std::size_t i = 0; i < slab.x.size(); ++i) {
    slab.opening[i] = opening.at(slab.x[i]);
    slab.cold[i] += followed * (slab.opening[i] - best.opening[i]);
  }
  return slab;
}

}  // namespace

double MouldTrial::residual(double wanted) const {
  double most = 0.0;
  for (const double half : cold) most = std::max(most, std::abs(half - wanted));
  return most;
}

const MouldTrial* best_trial(const std::vector<MouldTrial>& history, double wanted) {
  if (history.empty()) return nullptr;
  return &*std::ranges::min_element(
      history, {}, [wanted](const MouldTrial& trial) { return trial.residual(wanted); });
}

std::optional<MouldOpening> next_opening(const std::vector<MouldTrial>& history,
                                         const MouldTarget& target) {
  const MouldTrial* best = best_trial(history, target.wanted);
  if (best == nullptr || best->residual(target.wanted) <= target.tolerance) return std::nullopt;
  const std::vector<double> x = common_places(history);
  std::vector<MouldTrial> trials;
  for (const MouldTrial& trial : history) trials.push_back(sampled(trial, x));
  const double followed = 1.0 - eaten_share(trials);
  const MouldTrial from = sampled(*best, x);
  std::vector<double> corrected = from.opening;
  for (std::size_t i = 0; i < x.size(); ++i)
    corrected[i] += (target.wanted - from.cold[i]) / followed;
  const MouldOpening next = nearest_opening(x, corrected, target.bounds);
  const double promised = predicted(from, next, followed).residual(target.wanted);
  if (promised > worth_a_run * best->residual(target.wanted)) return std::nullopt;
  return next;
}

}  // namespace dccast::studies
