#include "server/studies/mould_opening.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "proto/values/interpolation.hpp"

namespace dccast::studies {

namespace {

using frames::SteadyFace;

constexpr double break_point_unit = 1e-3;  // [m] resolution at which moulds are made
constexpr double height_unit = 1e-5;       // [m]
constexpr int coarse_places = 48;          // of each break point in the first search

/// middle - first * (x - x1)+ - second * (x - x2)+, with break points x1 < x2. Convex and narrowing
/// outwards if no slope is negative.
struct Slopes {
  double middle = 0.0, first = 0.0, second = 0.0;
  double error = std::numeric_limits<double>::infinity();  ///< sum of squares [m2]
};

double beyond(double x, double from) {
  return std::max(0.0, x - from);
}

/// Openings with given break points, fitted to half-openings at some places by least squares.
class Fit {
public:
  Fit(const std::vector<double>& x, const std::vector<double>& half, const OpeningBounds& bounds)
      : x_(x), bounds_(bounds), half_(Eigen::Map<const Eigen::VectorXd>(half.data(), size())) {
    for (double& h : half_) h = std::clamp(h, bounds.least, bounds.most);
  }

  /// Fit with non-negative slopes: solves with each subset of the slopes and returns the best
  /// solution that has no negative slope.
  Slopes at(double first, double second) const {
    Slopes best;
    for (const bool use_first : {true, false})
      for (const bool use_second : {true, false}) {
        const auto found = solved(first, second, use_first, use_second);
        if (found && found->error < best.error) best = *found;
      }
    return best;
  }

  MouldOpening opening(double first, double second) const {
    const Slopes s = at(first, second);
    MouldOpening opening{{0.0, first, second, bounds_.length}, {}};
    for (std::size_t i = 0; i < 4; ++i)
      opening.half[i] = s.middle - s.first * beyond(opening.x[i], first) -
                        s.second * beyond(opening.x[i], second);
    return opening;
  }

private:
  Eigen::Index size() const { return x_.size(); }

  std::optional<Slopes> solved(double first, double second, bool use_first, bool use_second) const {
    Eigen::MatrixXd terms = Eigen::MatrixXd::Zero(size(), 3);
    for (Eigen::Index i = 0; i < size(); ++i) {
      const double x = x_[i];
      terms(i, 0) = 1.0;
      if (use_first) terms(i, 1) = -beyond(x, first);
      if (use_second) terms(i, 2) = -beyond(x, second);
    }
    const Eigen::Vector3d value = terms.completeOrthogonalDecomposition().solve(half_);
    if (value(1) < 0.0 || value(2) < 0.0) return std::nullopt;
    return Slopes{value(0), value(1), value(2), (terms * value - half_).squaredNorm()};
  }

  const std::vector<double>& x_;
  const OpeningBounds& bounds_;
  Eigen::VectorXd half_;
};

double rounded(double value, double unit) {
  return std::round(value / unit) * unit;
}

double rounded_up(double value, double unit) {
  constexpr double round_off = 1e-6;
  return std::ceil(value / unit - round_off) * unit;
}

struct BreakPoints {
  double first, second;
};

/// Best break points on a lattice between two pairs.
/// @param space  [m] least distance of the two
BreakPoints search(const Fit& fit, double space, const BreakPoints& low, const BreakPoints& high,
                   double step) {
  BreakPoints best{low.first, low.second};
  double least = std::numeric_limits<double>::infinity();
  constexpr double round_off = 1e-9;
  for (double first = low.first; first <= high.first + round_off; first += step)
    for (double second = std::max(low.second, first + space); second <= high.second + round_off;
         second += step)
      if (const double error = fit.at(first, second).error; error < least) {
        least = error;
        best = {first, second};
      }
  return best;
}

/// Rounds the heights to height_unit so that the mould stays convex. Rounded one by one they could
/// become hollow by a hundredth, so each is lowered, going outwards, as far as convexity needs.
void round_heights(MouldOpening& opening, const OpeningBounds& bounds) {
  for (double& h : opening.half) h = rounded(std::clamp(h, bounds.least, bounds.most), height_unit);
  auto& half = opening.half;
  half[1] = half[0];
  half[2] = std::min(half[2], half[1]);

  const double slope = (half[2] - half[1]) / (opening.x[2] - opening.x[1]);
  const double straight = half[2] + slope * (opening.x[3] - opening.x[2]);
  constexpr double round_off = 1e-9;
  half[3] = std::min(half[3], height_unit * std::floor(straight / height_unit + round_off));
  if (half[3] >= bounds.least) return;

  // The least opening lies above the convex continuation: use one slope from the first break point.
  half[3] = bounds.least;
  const double share = (opening.x[2] - opening.x[1]) / (opening.x[3] - opening.x[1]);
  half[2] = height_unit * std::ceil((half[1] + share * (half[3] - half[1])) / height_unit);
}

constexpr int places = 61;  // along the face, at which trials are compared
// A further run must promise a residual at least a tenth smaller.
constexpr double worth_a_run = 0.9;
// Bounds on the share of a change of the mould that contraction takes up: a correction is at least
// half and at most twice of what a slab lacks.
constexpr double least_share = -1.0, most_share = 0.5;

/// Places along the face that all trials cover [m].
std::vector<double> common_places(const std::vector<SteadyFace>& history) {
  double end = history.front().x_m.back();
  for (const SteadyFace& trial : history) end = std::min(end, trial.x_m.back());
  std::vector<double> x;
  for (int i = 0; i + 1 < places; ++i) x.push_back(end * i / (places - 1));
  x.push_back(end);
  return x;
}

SteadyFace sampled(const SteadyFace& trial, const std::vector<double>& x) {
  return {.x_m = x,
          .mould_m = values::at_instants(x, trial.x_m, trial.mould_m),
          .cold_m = values::at_instants(x, trial.x_m, trial.cold_m)};
}

/// Share of a change of the opening that contraction takes up, by least squares over all pairs of
/// successive trials.
double eaten_share(const std::vector<SteadyFace>& trials) {
  double product = 0.0, square = 0.0;
  for (std::size_t t = 0; t + 1 < trials.size(); ++t) {
    const SteadyFace &from = trials[t], &to = trials[t + 1];
    for (std::size_t i = 0; i < from.x_m.size(); ++i) {
      const double opening = to.mould_m[i] - from.mould_m[i];
      const double contraction = opening - (to.cold_m[i] - from.cold_m[i]);
      product += contraction * opening;
      square += opening * opening;
    }
  }
  return square == 0.0 ? 0.0 : std::clamp(product / square, least_share, most_share);
}

/// Slab of an opening, if it follows the change from the best trial's mould by a given share.
SteadyFace predicted(const SteadyFace& best, const MouldOpening& opening, double followed) {
  SteadyFace slab = best;
  for (std::size_t i = 0; i < slab.x_m.size(); ++i) {
    slab.mould_m[i] = opening.at(slab.x_m[i]);
    slab.cold_m[i] += followed * (slab.mould_m[i] - best.mould_m[i]);
  }
  return slab;
}

}  // namespace

double MouldOpening::at(double place) const {
  std::size_t right = 1;
  while (right < 3 && x[right] < place) ++right;
  const double share = std::clamp((place - x[right - 1]) / (x[right] - x[right - 1]), 0.0, 1.0);
  return half[right - 1] + share * (half[right] - half[right - 1]);
}

MouldOpening nearest_opening(const std::vector<double>& x, const std::vector<double>& half,
                             const OpeningBounds& bounds) {
  const Fit fit(x, half, bounds);

  // All lattice points are whole millimetres.
  const double space = rounded_up(bounds.spacing, break_point_unit);
  const double coarse = rounded_up(bounds.length / coarse_places, break_point_unit);
  const double last = -rounded_up(bounds.spacing - bounds.length, break_point_unit);
  const BreakPoints low{space, 2.0 * space}, high{last - space, last};

  const BreakPoints near = search(fit, space, low, high, coarse);
  const BreakPoints found = search(
      fit, space,
      {std::max(low.first, near.first - coarse), std::max(low.second, near.second - coarse)},
      {std::min(high.first, near.first + coarse), std::min(high.second, near.second + coarse)},
      break_point_unit);

  MouldOpening opening =
      fit.opening(rounded(found.first, break_point_unit), rounded(found.second, break_point_unit));
  round_heights(opening, bounds);
  return opening;
}

const SteadyFace* best_trial(const std::vector<SteadyFace>& history, double wanted) {
  if (history.empty()) return nullptr;
  return &*std::ranges::min_element(
      history, {}, [wanted](const SteadyFace& trial) { return trial.residual_m(wanted); });
}

std::optional<MouldOpening> next_opening(const std::vector<SteadyFace>& history,
                                         const MouldTarget& target) {
  const SteadyFace* best = best_trial(history, target.wanted);
  if (best == nullptr || best->residual_m(target.wanted) <= target.tolerance) return std::nullopt;

  const std::vector<double> x = common_places(history);
  std::vector<SteadyFace> trials;
  for (const SteadyFace& trial : history) trials.push_back(sampled(trial, x));

  // Open the mould by what the slab lacks, enlarged by what contraction takes up.
  const double followed = 1.0 - eaten_share(trials);
  const SteadyFace from = sampled(*best, x);
  std::vector<double> corrected = from.mould_m;
  for (std::size_t i = 0; i < x.size(); ++i)
    corrected[i] += (target.wanted - from.cold_m[i]) / followed;

  const MouldOpening next = nearest_opening(x, corrected, target.bounds);
  const double promised = predicted(from, next, followed).residual_m(target.wanted);
  if (promised > worth_a_run * best->residual_m(target.wanted)) return std::nullopt;
  return next;
}

}  // namespace dccast::studies
