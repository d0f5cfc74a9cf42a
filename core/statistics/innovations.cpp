#include "core/statistics/innovations.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "core/statistics/sampling.hpp"

namespace dccast::statistics {

namespace {

constexpr double window = 10.0;         ///< of the sum [s]
constexpr double before_window = 20.0;  ///< of the least squares [s]
constexpr double limit = 4.2;           ///< of the sum over the root of its number
constexpr int outliers_in_row = 4;
constexpr double surely_a_step = 9.0;  ///< [variances of a reading]

/// The readings of the window up to one of them.
struct Recent {
  double statistic = 0.0;  ///< sum of normalised innovations over the root of their number
  double mean = 0.0;       ///< of reading minus expectation [unit]
  double begin = 0.0;      ///< [s]
};

Recent recent_up_to(const std::vector<Innovation>& innovations, const std::vector<double>& scaled,
                    std::size_t last) {
  Recent recent;
  std::size_t count = 0;
  for (std::size_t i = last + 1; i-- > 0;) {
    if (innovations[i].time <= innovations[last].time - window) break;
    recent.statistic += std::clamp(scaled[i], -farthest_innovation, farthest_innovation);
    recent.mean += innovations[i].reading - innovations[i].expected.value;
    recent.begin = innovations[i].time;
    ++count;
  }

  recent.statistic /= std::sqrt(static_cast<double>(count));
  recent.mean /= static_cast<double>(count);
  return recent;
}

/// A straight line and one more column, fitted to readings minus their first mean.
struct Fit {
  double remainder = std::numeric_limits<double>::infinity();  ///< sum of squares [unit^2]
  double size = 0.0;                                           ///< of the further column
};

template <typename Column>
Fit fit(std::span<const Innovation> readings, Column column) {
  const auto rows = static_cast<Eigen::Index>(readings.size());
  Eigen::MatrixXd columns(rows, 3);
  Eigen::VectorXd off(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const Innovation& each = readings[static_cast<std::size_t>(i)];
    columns.row(i) << 1.0, each.time - readings.front().time, column(each.time);
    off(i) = each.reading - each.first_mean;
  }
  const Eigen::VectorXd found = columns.colPivHouseholderQr().solve(off);
  return {(off - columns * found).squaredNorm(), found(2)};
}

/// The readings around a departure.
std::span<const Innovation> around(const std::vector<Innovation>& innovations, double time) {
  const auto begin =
      std::ranges::lower_bound(innovations, time - before_window, {}, &Innovation::time);
  const auto end = std::ranges::upper_bound(innovations, time + window, {}, &Innovation::time);
  return {begin, end};
}

/// Tells a step from a drift.
Departure described(const std::vector<Innovation>& innovations, std::size_t at,
                    const Recent& recent, double noise) {
  const Departure drift{Departure::Kind::drift, innovations[at].time, recent.begin, recent.mean};
  const auto readings = around(innovations, drift.time);

  // Both ends keep two readings, which a step would otherwise follow as they are.
  Departure step{Departure::Kind::step, drift.time, drift.time, 0.0};
  double of_steps = std::numeric_limits<double>::infinity(), of_bends = of_steps;
  for (std::size_t i = 2; i + 2 < readings.size(); ++i) {
    const double from = readings[i].time, before = readings[i - 1].time;
    const Fit as_step = fit(readings, [&](double t) { return t < from ? 0.0 : 1.0; });
    const Fit as_bend = fit(readings, [&](double t) { return std::max(t - before, 0.0); });
    of_bends = std::min(of_bends, as_bend.remainder);
    if (as_step.remainder >= of_steps) continue;
    of_steps = as_step.remainder;
    step.begin = from;
    step.size = as_step.size;
  }
  return of_bends - of_steps > surely_a_step * noise * noise ? step : drift;
}

/// At most 100 instants of an ensemble, evenly spread: the cost grows with their third power.
TrajectoryEnsemble thinned(const TrajectoryEnsemble& ensemble) {
  const auto kept = spread_indices(ensemble.time.size(), 100);
  TrajectoryEnsemble thin{.time = ensemble.time(kept),
                          .nominal = ensemble.nominal(kept),
                          .members = ensemble.members(Eigen::all, kept),
                          .misfits = {},
                          .model_error = ensemble.model_error};
  if (ensemble.misfits.rows() > 0) thin.misfits = ensemble.misfits(Eigen::all, kept);
  return thin;
}

/// (instant, instant) adds up independent numbers over the window before each instant, and divides
/// by the root of their count.
Eigen::MatrixXd window_sums(const Eigen::VectorXd& time) {
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(time.size(), time.size());
  for (Eigen::Index row = 0; row < time.size(); ++row) {
    const double* const begin =
        std::upper_bound(time.data(), time.data() + row, time(row) - window);
    const Eigen::Index first = begin - time.data(), count = row + 1 - first;
    sums.row(row).segment(first, count).setConstant(1.0 / std::sqrt(static_cast<double>(count)));
  }
  return sums;
}

/// The statistic of some members that the others forecast, and two standard deviations of what
/// noise adds to it.
/// @param others  the ensemble without these members
/// @return        (member, instant)
Eigen::MatrixXd reached_by(const Eigen::MatrixXd& members, const TrajectoryEnsemble& others,
                           const Gauge& gauge, const Eigen::MatrixXd& sums) {
  // What is read at an instant stands for all readings since the one before it.
  const Eigen::Index instants = others.time.size();
  const double whole = others.time(instants - 1) - others.time(0);
  const double spacing = whole / static_cast<double>(instants - 1);
  const double noise = gauge.noise / std::sqrt(std::max(spacing, 1.0));

  // The innovations of normal readings are their deviations times the inverse of L.
  Eigen::MatrixXd variance = prior_of(others).covariance;
  variance.array() += gauge.zero * gauge.zero;
  variance.diagonal().array() += noise * noise;
  const Eigen::LLT<Eigen::MatrixXd> factored(variance);
  const Eigen::MatrixXd to_statistic =
      sums * factored.matrixL().solve(Eigen::MatrixXd::Identity(instants, instants));

  const Eigen::RowVectorXd expected = others.members.colwise().mean();
  const Eigen::MatrixXd of_members = to_statistic * (members.rowwise() - expected).transpose();
  const Eigen::VectorXd of_noise = noise * to_statistic.rowwise().norm();
  const Eigen::VectorXd of_zero = gauge.zero * to_statistic.rowwise().sum();
  const Eigen::VectorXd deviation = (of_noise.array().square() + of_zero.array().square()).sqrt();
  return (of_members.cwiseAbs().colwise() + 2.0 * deviation).transpose();
}

/// The largest statistic near each of some values of the quantity, over the limit; one at least.
/// @param members, reached  (member, instant) the quantity and the statistic
/// @param within            how far a member may be from a value [unit]
Eigen::VectorXd largest_near(const Eigen::VectorXd& values, double within,
                             const Eigen::MatrixXd& members, const Eigen::MatrixXd& reached) {
  Eigen::VectorXd largest = Eigen::VectorXd::Ones(values.size());
  for (Eigen::Index i = 0; i < members.size(); ++i)
    for (Eigen::Index at = 0; at < values.size(); ++at)
      if (std::abs(members(i) - values(at)) <= within)
        largest(at) = std::max(largest(at), reached(i) / limit);
  return largest;
}

}  // namespace

double normalised(const Innovation& innovation) {
  return (innovation.reading - innovation.expected.value) / innovation.expected.deviation;
}

Curve member_scale(const TrajectoryEnsemble& whole, const Gauge& gauge) {
  const TrajectoryEnsemble ensemble = thinned(whole);
  const double lowest = ensemble.members.minCoeff(), highest = ensemble.members.maxCoeff();
  if (highest <= lowest) return Curve(1.0);

  const Eigen::MatrixXd sums = window_sums(ensemble.time);
  Eigen::MatrixXd reached(ensemble.members.rows(), ensemble.members.cols());
  constexpr Eigen::Index parts = 6;
  for (Eigen::Index part = 0; part < parts; ++part) {
    std::vector<Eigen::Index> forecast, used;
    for (Eigen::Index i = 0; i < ensemble.members.rows(); ++i)
      (i % parts == part ? forecast : used).push_back(i);
    if (forecast.empty()) continue;

    TrajectoryEnsemble others = ensemble;
    others.members = ensemble.members(used, Eigen::all);
    reached(forecast, Eigen::all) =
        reached_by(ensemble.members(forecast, Eigen::all), others, gauge, sums);
  }

  constexpr Eigen::Index points = 100;
  const Eigen::VectorXd values = Eigen::VectorXd::LinSpaced(points, lowest, highest);
  const double within = 2.0 * gauge.noise + 0.5 * (values(1) - values(0));
  const Eigen::VectorXd scale = largest_near(values, within, ensemble.members, reached);
  return {Abscissa::distance, {values.begin(), values.end()}, {scale.begin(), scale.end()}};
}

std::vector<Departure> find_departures(const std::vector<Innovation>& innovations, double noise,
                                       const Curve& scale) {
  std::vector<double> scaled;
  for (const Innovation& each : innovations)
    scaled.push_back(normalised(each) / scale(each.expected.value));

  std::vector<Departure> departures;
  bool departed = false;
  int row = 0;  // of outliers up to here
  for (std::size_t i = 0; i < innovations.size(); ++i) {
    const Recent recent = recent_up_to(innovations, scaled, i);
    row = std::abs(scaled[i]) > farthest_innovation ? row + 1 : 0;
    const bool leaves = std::abs(recent.statistic) > limit || row >= outliers_in_row;
    if (leaves && !departed) departures.push_back(described(innovations, i, recent, noise));
    departed = leaves || (departed && std::abs(recent.statistic) > 0.5 * limit);
  }
  return departures;
}

}  // namespace dccast::statistics
