#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/results/result_reader.hpp"
#include "tests/unit/casting/small_quarter_slab.hpp"

namespace dccast::casting {
namespace {

using testing::bytes_of;
using testing::equal_except_timing;
using testing::Recorder;
using testing::small_casting;

/// Readings of every second, which arrive one at a time whenever the run waits.
class Plant : public LeverFeed {
public:
  /// @param readings  by time  @param at_once  how many arrive before the run waits at all
  explicit Plant(std::vector<LeverReading> readings, std::size_t at_once = 0)
      : readings_(std::move(readings)), known_(at_once) {}

  Arrived wait_until(double time) override {
    asked_.push_back(time);
    Arrived arrived;
    if (asked_.size() == stop_at_) arrived.order = Order::stop_at_checkpoint;
    if (arrived.order == Order::go_on && known_ < readings_.size()) ++known_;
    arrived.readings.assign(readings_.begin() + taken_, readings_.begin() + known_);
    taken_ = static_cast<std::ptrdiff_t>(known_);
    arrived.closed = known_ == readings_.size();
    return arrived;
  }
  void stop_at(std::size_t call) { stop_at_ = call; }
  std::size_t calls() const { return asked_.size(); }

private:
  std::vector<LeverReading> readings_;
  std::size_t known_;
  std::ptrdiff_t taken_ = 0;
  std::vector<double> asked_;
  std::size_t stop_at_ = 0;
};

/// Speed and water of a casting that is up to a fifth faster and wetter than planned.
std::vector<LeverReading> readings_of_plant(double from, double to) {
  std::vector<LeverReading> readings;
  for (double t = from; t <= to; t += 1.0) {
    LeverReading r{.time = t, .value = {}};
    const double factor = 1.0 + 0.2 * std::sin(0.3 * t);
    r.of(Lever::casting_speed) = t < 0.0 ? 0.0 : 1e-3 * factor;
    r.of(Lever::water_flow) = 2e-3 * factor;
    readings.push_back(r);
  }
  return readings;
}

/// Integral of the measured speed up to a time, by the trapezoidal rule, which is exact for it [m].
double length_of(const std::vector<LeverReading>& readings, double until) {
  double length = 0.0;
  for (std::size_t i = 1; i < readings.size() && readings[i - 1].time < until; ++i) {
    const LeverReading &a = readings[i - 1], &b = readings[i];
    const double v = a.of(Lever::casting_speed).value(), w = b.of(Lever::casting_speed).value();
    const double share = std::min((until - a.time) / (b.time - a.time), 1.0);
    length += share * (b.time - a.time) * (v + 0.5 * share * (w - v));
  }
  return length;
}

double last_cast_length(const Recorder& recorder) {
  return recorder.reports.back().cast_length;
}

TEST(FollowedRun, GoesAsFarAsTheReadingsAndEndsWithThem) {
  const TemporaryFolder folder;
  Recorder recorder;
  const auto readings = readings_of_plant(-10.0, 8.0);
  Plant plant(readings);
  const Case c = small_casting();
  ASSERT_EQ(run(c, {folder / "", false}, recorder, 1, &plant).end, RunEnd::succeeded);

  const double end = recorder.reports.back().time;
  EXPECT_LE(end, 8.0);
  EXPECT_GT(end, 8.0 - 1.01) << "the next step would have gone beyond the last reading";
  EXPECT_NEAR(last_cast_length(recorder), length_of(readings, end), 1e-12);
  // The file has the record, from which the casting can be computed again.
  const results::MeasuredLevers stored = results::ResultReader(folder / "results.h5").levers();
  ASSERT_EQ(stored.time.size(), readings.size());
  EXPECT_EQ(stored.time.back(), 8.0);
  EXPECT_EQ(stored.of(Lever::water_flow)[3], readings[3].of(Lever::water_flow));
  EXPECT_TRUE(std::isnan(stored.of(Lever::casting_temperature)[3])) << "not measured";
}

TEST(FollowedRun, OfThePlanIsThePlan) {
  const TemporaryFolder planned, followed;
  Recorder of_plan, of_feed;
  const Case c = small_casting();
  Plant silent({LeverReading{.time = 25.0, .value = {}}});
  ASSERT_EQ(run(c, {planned / "", false}, of_plan).end, RunEnd::succeeded);
  ASSERT_EQ(run(c, {followed / "", false}, of_feed, 1, &silent).end, RunEnd::succeeded);
  ASSERT_EQ(of_feed.reports.size(), of_plan.reports.size());
  for (std::size_t i = 0; i < of_plan.reports.size(); ++i)
    EXPECT_TRUE(equal_except_timing(of_feed.reports[i], of_plan.reports[i])) << i;
}

/// The record computed again in one go gives the bytes of the casting that was followed.
TEST(FollowedRun, RepeatedGivesTheSameBytes) {
  const auto readings = readings_of_plant(-10.0, 25.0);
  const TemporaryFolder live, again;
  Recorder first, second;
  Plant plant(readings), log(readings, readings.size());
  const Case c = small_casting();
  ASSERT_EQ(run(c, {live / "", false}, first, 1, &plant).end, RunEnd::succeeded);
  ASSERT_EQ(run(c, {again / "", false}, second, 1, &log).end, RunEnd::succeeded);
  EXPECT_EQ(first.reports.back().time, 20.0);
  EXPECT_TRUE(bytes_of(live / "results.h5") == bytes_of(again / "results.h5"));

  Recorder of_plan;
  const TemporaryFolder planned;
  ASSERT_EQ(run(c, {planned / "", false}, of_plan).end, RunEnd::succeeded);
  EXPECT_NE(last_cast_length(of_plan), last_cast_length(first)) << "the readings count";
}

TEST(FollowedRun, StopsWhileItWaitsAndGoesOnWithTheSameBytes) {
  const auto readings = readings_of_plant(-10.0, 25.0);
  const TemporaryFolder whole, parts;
  Recorder uninterrupted, first, second;
  Plant plant(readings), stopped(readings), log(readings, 12);
  const Case c = small_casting();
  ASSERT_EQ(run(c, {whole / "", false}, uninterrupted, 1, &plant).end, RunEnd::succeeded);

  stopped.stop_at(15);
  ASSERT_EQ(run(c, {parts / "", false}, first, 1, &stopped).end, RunEnd::stopped);
  second.before = first.reports;
  ASSERT_EQ(run(c, {parts / "", true}, second, 1, &log).end, RunEnd::succeeded);
  EXPECT_EQ(second.resumed_from, first.reports.back().step);
  EXPECT_TRUE(bytes_of(whole / "results.h5") == bytes_of(parts / "results.h5"));
  EXPECT_TRUE(equal_except_timing(second.reports.back(), uninterrupted.reports.back()));
}

/// The record ends at a frame, and the run has stopped there before it knew.
TEST(FollowedRun, ResumedAtItsLastStepStoresTheLastFrameOnce) {
  const auto readings = readings_of_plant(-10.0, 5.0);
  const TemporaryFolder whole, parts;
  Recorder uninterrupted, first, second;
  Plant plant(readings), stopped(readings), log(readings, readings.size());
  const Case c = small_casting();
  ASSERT_EQ(run(c, {whole / "", false}, uninterrupted, 1, &plant).end, RunEnd::succeeded);

  stopped.stop_at(plant.calls());
  ASSERT_EQ(run(c, {parts / "", false}, first, 1, &stopped).end, RunEnd::stopped);
  ASSERT_EQ(first.reports.back().time, 5.0);
  second.before = first.reports;
  ASSERT_EQ(run(c, {parts / "", true}, second, 1, &log).end, RunEnd::succeeded);
  EXPECT_TRUE(second.reports.empty());
  EXPECT_TRUE(bytes_of(whole / "results.h5") == bytes_of(parts / "results.h5"));
}

TEST(FollowedRun, OfAQuarterSlabFollowsSpeedAndWater) {
  const TemporaryFolder folder;
  Recorder recorder;
  const auto readings = readings_of_plant(-10.0, 40.0);
  Plant plant(readings);
  Case c = testing::small_quarter_slab();
  c.time.end = 4.0;
  ASSERT_EQ(run(c, {folder / "", false}, recorder, 1, &plant).end, RunEnd::succeeded);
  EXPECT_NEAR(last_cast_length(recorder), length_of(readings, 4.0), 1e-12);
  for (const auto& r : recorder.reports) EXPECT_LE(std::abs(r.energy_balance_error), 1e-10);
}

}  // namespace
}  // namespace dccast::casting
