#include "core/statistics/innovations.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <random>

#include "core/statistics/gaussian_process.hpp"
#include "core/statistics/sampling.hpp"

namespace dccast::statistics {
namespace {

// Millimetres and seconds, as of the corner of a slab.
constexpr Gauge gauge{.noise = 1.0, .zero = 2.0};
constexpr double fault_time = 80.0;
constexpr int castings = 200;

/// A curl of 30 mm with a scatter that grows to 6 mm.
TrajectoryPrior prior() {
  const Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(101, 0.0, 200.0);
  const Eigen::VectorXd nominal = 30.0 * (1.0 - (-time.array() / 60.0).exp());
  const Eigen::VectorXd scale = 0.2 * nominal.array() + 0.2;
  const Eigen::VectorXd length = Eigen::VectorXd::Constant(1, 80.0);
  return {time, nominal, Eigen::VectorXd::Zero(101),
          scale.asDiagonal() * correlation(time, time, length) * scale.asDiagonal()};
}

/// What is wrong with a casting, from fault_time on.
struct Fault {
  double slip = 0.0;   ///< of the gauge [mm]
  double drift = 0.0;  ///< of the curl in a minute [mm]
  double at(double time) const {
    return time < fault_time ? 0.0 : slip + drift * (time - fault_time) / 60.0;
  }
};

/// A curl that is drawn from the prior.
Eigen::VectorXd drawn(const TrajectoryPrior& p, std::mt19937_64& random) {
  const Eigen::Index n = p.time.size();
  const Eigen::MatrixXd regular = p.covariance + 1e-9 * Eigen::MatrixXd::Identity(n, n);
  const Eigen::VectorXd numbers =
      Eigen::VectorXd::NullaryExpr(n, [&](Eigen::Index) { return normal(random); });
  return p.nominal + regular.llt().matrixL() * numbers;
}

/// Readings of every second of a casting whose curl is given at the instants of the prior, two
/// seconds apart.
std::vector<Innovation> simulated(const TrajectoryPrior& p, const Eigen::VectorXd& truth,
                                  const Fault& fault, std::mt19937_64& random) {
  const double zero = gauge.zero * normal(random);

  std::vector<Innovation> innovations;
  const TrajectoryForecast first(p, gauge);
  TrajectoryForecast forecast(p, gauge);
  for (double t = 0.0; t < p.time.tail<1>()(0); t += 1.0) {
    const auto left = static_cast<Eigen::Index>(t / 2.0);
    const double share = t / 2.0 - static_cast<double>(left);
    const double curl = (1.0 - share) * truth(left) + share * truth(left + 1);
    const double reading = curl + zero + fault.at(t) + gauge.noise * normal(random);
    innovations.push_back(
        {t, reading, first.expected_reading(t).value, forecast.expected_reading(t)});
    if (std::abs(normalised(innovations.back())) <= farthest_innovation) forecast.learn(t, reading);
  }
  return innovations;
}

using Castings = std::vector<std::vector<Innovation>>;

Castings simulated_castings(const Fault& fault, unsigned first_seed) {
  const TrajectoryPrior p = prior();
  Castings made;
  for (unsigned i = 0; i < castings; ++i) {
    std::mt19937_64 random(first_seed + i);
    const Eigen::VectorXd truth = drawn(p, random);
    made.push_back(simulated(p, truth, fault, random));
  }
  return made;
}

/// What a watch made of castings with the same fault.
struct Outcome {
  double found = 0.0;    ///< share of castings, within a minute of the fault
  double seconds = 0.0;  ///< mean time until then, of those found
  double steps = 0.0;    ///< share of those found that it took for a step
  double early = 0.0;    ///< share of castings with an alarm before the fault
};

/// @param watch  gives the first departure after a time
template <typename Watch>
Outcome outcome_of(const char* name, const Castings& faulty, Watch watch) {
  Outcome outcome;
  int found = 0, steps = 0, early = 0;
  for (const auto& innovations : faulty) {
    const std::optional<Departure> any = watch(innovations, -1.0);
    early += any && any->time < fault_time;
    const std::optional<Departure> after = watch(innovations, fault_time);
    if (!after || after->time > fault_time + 60.0) continue;
    ++found;
    steps += after->kind == Departure::Kind::step;
    outcome.seconds += after->time - fault_time;
  }
  outcome.found = static_cast<double>(found) / castings;
  outcome.early = static_cast<double>(early) / castings;
  outcome.seconds /= std::max(found, 1);
  outcome.steps = static_cast<double>(steps) / std::max(found, 1);
  std::printf("%-34s found %3.0f %%, after %4.1f s; steps %3.0f %%; early %4.1f %%\n", name,
              100.0 * outcome.found, outcome.seconds, 100.0 * outcome.steps, 100.0 * outcome.early);
  return outcome;
}

std::optional<Departure> by_innovations(const std::vector<Innovation>& innovations, double from) {
  for (const Departure& departure : find_departures(innovations, gauge.noise))
    if (departure.time >= from) return departure;
  return std::nullopt;
}

/// The plain watch: a reading farther from the first mean than so many millimetres.
auto by_threshold(double most) {
  return [=](const std::vector<Innovation>& innovations, double from) -> std::optional<Departure> {
    for (const Innovation& each : innovations)
      if (each.time >= from && std::abs(each.reading - each.first_mean) > most)
        return Departure{Departure::Kind::drift, each.time, each.time, 0.0};
    return std::nullopt;
  };
}

/// The threshold that one sound casting of a hundred exceeds [mm].
double threshold_of_sound_castings() {
  std::vector<double> largest;
  for (const auto& innovations : simulated_castings({}, 0)) {
    double most = 0.0;
    for (const Innovation& each : innovations)
      most = std::max(most, std::abs(each.reading - each.first_mean));
    largest.push_back(most);
  }
  std::ranges::sort(largest);
  return largest[castings - 1 - castings / 100];
}

/// The innovations are kept only because they beat the plain threshold at equal false alarms.
TEST(Innovations, FindASlippedGaugeAndAFastDriftBetterThanAThreshold) {
  const double threshold = threshold_of_sound_castings();
  std::printf("threshold %.1f mm\n", threshold);
  const auto plain = by_threshold(threshold);

  const Outcome sound =
      outcome_of("sound, innovations", simulated_castings({}, 1000), by_innovations);
  EXPECT_LE(sound.found + sound.early, 0.02);

  const Castings slipped = simulated_castings({.slip = 4.0}, 1000);
  const Outcome slip = outcome_of("slip of 4 mm, innovations", slipped, by_innovations);
  const Outcome slip_plain = outcome_of("slip of 4 mm, threshold", slipped, plain);
  EXPECT_GE(slip.found, 0.95);
  EXPECT_LE(slip.seconds, 6.0);
  EXPECT_GE(slip.steps, 0.9);
  EXPECT_LT(slip_plain.found, 0.1);

  const Castings fast = simulated_castings({.drift = -24.0}, 1000);
  const Outcome drift = outcome_of("24 mm in a minute, innovations", fast, by_innovations);
  const Outcome drift_plain = outcome_of("24 mm in a minute, threshold", fast, plain);
  EXPECT_GE(drift.found, drift_plain.found);
  EXPECT_LT(drift.seconds, 0.5 * drift_plain.seconds);
  EXPECT_LE(drift.steps, 0.05);

  // What water of -30 % does: data that nobody knows move the curl by as much.
  const Castings slow = simulated_castings({.drift = -4.0}, 1000);
  outcome_of("4 mm in a minute, innovations", slow, by_innovations);
  outcome_of("4 mm in a minute, threshold", slow, plain);
}

/// Members of an ensemble without error of mesh and model.
TrajectoryEnsemble ensemble_of(const Eigen::VectorXd& time, const Eigen::MatrixXd& members) {
  return {.time = time,
          .nominal = members.colwise().mean(),
          .members = members,
          .misfits = {},
          .model_error = 0.0};
}

TEST(ScaleOfMembers, IsOneForNormalMembers) {
  std::mt19937_64 random(1);
  const TrajectoryPrior p = prior();
  Eigen::MatrixXd members(36, p.time.size());
  for (Eigen::Index i = 0; i < members.rows(); ++i) members.row(i) = drawn(p, random).transpose();

  const Curve scale = member_scale(ensemble_of(p.time, members), gauge);
  EXPECT_LE(std::ranges::max(scale.value()), 1.1);
  EXPECT_GE(std::ranges::min(scale.value()), 1.0);
}

/// Curls that begin each at its own time, as those of slabs do.
Eigen::MatrixXd curls_with_own_begin(const Eigen::VectorXd& time, Eigen::Index count,
                                     std::mt19937_64& random) {
  Eigen::MatrixXd curls(count, time.size());
  for (Eigen::Index i = 0; i < count; ++i) {
    const double begin = 35.0 + 8.0 * normal(random),
                 height = 30.0 * std::exp(0.2 * normal(random));
    const double rise = 60.0 * std::exp(0.25 * normal(random));
    const double later = 80.0 + 15.0 * normal(random), more = 4.0 * normal(random);
    const Eigen::ArrayXd since = (time.array() - begin).cwiseMax(0.0);
    curls.row(i) = height * (1.0 - (-since / rise).exp()) * since / (since + 6.0) +
                   more * ((time.array() - later) / 20.0).cwiseMax(0.0).cwiseMin(1.0);
  }
  return curls;
}

TEST(ScaleOfMembers, LeavesFewerSoundCastingsWithAWarningAndFindsFaultsLater) {
  const Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(126, 0.0, 250.0);
  constexpr Eigen::Index count = 100;
  int plain = 0, scaled = 0, found = 0;
  for (const unsigned seed : {1u, 2u, 3u}) {
    std::mt19937_64 random(seed);
    TrajectoryEnsemble ensemble = ensemble_of(time, curls_with_own_begin(time, 36, random));
    ensemble.model_error = 0.05;
    const TrajectoryPrior p = prior_of(ensemble);
    const Curve scale = member_scale(ensemble, gauge);

    const Eigen::MatrixXd truths = curls_with_own_begin(time, count, random);
    for (const auto& truth : truths.rowwise()) {
      const auto sound = simulated(p, truth.transpose(), {}, random);
      plain += !find_departures(sound, gauge.noise).empty();
      scaled += !find_departures(sound, gauge.noise, scale).empty();

      auto slipped = sound;
      for (Innovation& each : slipped)
        if (each.time >= 170.0) each.reading += 4.0;
      const auto departures = find_departures(slipped, gauge.noise, scale);
      found += !departures.empty() && departures.back().time >= 170.0;
    }
  }
  std::printf("of %d sound castings %d had a warning, %d with the scale; %d of those that slip\n",
              static_cast<int>(3 * count), plain, scaled, found);
  EXPECT_GE(plain, 3 * count / 25);
  EXPECT_LE(scaled, plain / 2);
  EXPECT_GE(found, 3 * count * 95 / 100);
}

std::vector<Innovation> steady(std::size_t count) {
  std::vector<Innovation> innovations(count);
  for (std::size_t i = 0; i < count; ++i)
    innovations[i] = {static_cast<double>(i), 0.0, 0.0, {0.0, 1.0}};
  return innovations;
}

TEST(Innovations, OneOutlierIsNoDepartureAndFourInARowAre) {
  auto innovations = steady(40);
  innovations[12].reading = 50.0;
  EXPECT_TRUE(find_departures(innovations, 1.0).empty());

  // By turns above and below: their sum says nothing.
  for (std::size_t i = 25; i < 29; ++i) innovations[i].reading = i % 2 ? 50.0 : -50.0;
  const auto found = find_departures(innovations, 1.0);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].time, 28.0);
}

TEST(Innovations, NameTimeAndHeightOfAStepAndReportItOnce) {
  auto innovations = steady(80);
  for (std::size_t i = 30; i < 80; ++i) innovations[i].reading = 3.0;
  const auto found = find_departures(innovations, 0.5);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].kind, Departure::Kind::step);
  EXPECT_EQ(found[0].begin, 30.0);
  EXPECT_NEAR(found[0].size, 3.0, 1e-9);
}

TEST(Innovations, ABendIsADrift) {
  auto innovations = steady(80);
  for (std::size_t i = 30; i < 80; ++i) innovations[i].reading = 0.4 * (innovations[i].time - 30.0);
  const auto found = find_departures(innovations, 0.5);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].kind, Departure::Kind::drift);
  EXPECT_GT(found[0].size, 0.0);
}

}  // namespace
}  // namespace dccast::statistics
