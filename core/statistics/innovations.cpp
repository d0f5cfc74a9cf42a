#include "core/statistics/innovations.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

namespace dccast::statistics {

namespace {

constexpr double window = 10.0;         ///< of the sum [s]
constexpr double before_window = 20.0;  ///< of the least squares [s]
constexpr double limit = 4.2;           ///< of the sum over the root of its number
constexpr int outliers_in_row = 4;
constexpr double surely_a_step = 9.0;   ///< [variances of a reading]

/// The readings of the window up to one of them.
struct Recent {
  double statistic = 0.0;  ///< sum of normalised innovations over the root of their number
  double mean = 0.0;       ///< of reading minus expectation [unit]
  double begin = 0.0;      ///< [s]
};

Recent recent_up_to(const std::vector<Innovation>& innovations, std::size_t last) {
  Recent recent;
  std::size_t count = 0;
  for (std::size_t i = last + 1; i-- > 0;) {
    if (innovations[i].time <= innovations[last].time - window) break;
    const double n = normalised(innovations[i]);
    recent.statistic += std::clamp(n, -farthest_innovation, farthest_innovation);
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
  const auto begin = std::ranges::lower_bound(innovations, time - before_window, {}, &Innovation::time);
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

}  // namespace

double normalised(const Innovation& innovation) {
  return (innovation.reading - innovation.expected.value) / innovation.expected.deviation;
}

std::vector<Departure> find_departures(const std::vector<Innovation>& innovations, double noise) {
  std::vector<Departure> departures;
  bool departed = false;
  int row = 0;  // of outliers up to here
  for (std::size_t i = 0; i < innovations.size(); ++i) {
    const Recent recent = recent_up_to(innovations, i);
    row = std::abs(normalised(innovations[i])) > farthest_innovation ? row + 1 : 0;
    const bool leaves = std::abs(recent.statistic) > limit || row >= outliers_in_row;
    if (leaves && !departed) departures.push_back(described(innovations, i, recent, noise));
    departed = leaves || (departed && std::abs(recent.statistic) > 0.5 * limit);
  }
  return departures;
}

}  // namespace dccast::statistics
