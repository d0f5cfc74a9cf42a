#include "client/session/source_clock.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dccast::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A source whose lines are placed one after the other.
class Source {
public:
  explicit Source(std::optional<double> jump_from_s = {}) : clock_(jump_from_s) {}
  explicit Source(SourceClock::History before) : clock_({}, std::move(before)) {}

  /// A line in real time. @param arrival_s  when it comes
  void live(double stamp_s, double arrival_s) { take(stamp_s, 1e5 + arrival_s, ++content_); }
  /// A line of a file.
  void read(double stamp_s) { take(stamp_s, {}, ++content_); }
  void repeat(double stamp_s, std::size_t content) { take(stamp_s, {}, content); }
  const SourceClock::History& history() const { return clock_.history(); }

  std::vector<double> times;
  std::vector<std::string> jumps, gaps;
  int earlier = 0;

private:
  void take(double stamp_s, std::optional<double> arrival_s, std::size_t content) {
    const auto placed = clock_.place(stamp_s, arrival_s, content);
    if (placed.is_earlier)
      ++earlier;
    else
      times.push_back(placed.time_s);
    if (!placed.remark.empty()) (placed.is_jump ? jumps : gaps).push_back(placed.remark);
  }

  SourceClock clock_;
  std::size_t content_ = 1000;
};

TEST(SourceClock, ASourceInRealTimeIsMeasuredByItsArrivals) {
  for (const double by : {874.0, 5.5, 31e6}) {
    Source source;
    for (int t = 0; t <= 60; ++t) source.live(t + (t > 20 ? by : 0.0), t + 0.1 * (t % 3));
    ASSERT_EQ(source.times.size(), 61u) << by;
    EXPECT_NEAR(source.times.back(), 60.0, 0.3) << by;
    EXPECT_THAT(source.jumps, ElementsAre(HasSubstr("The arrival counts"))) << by;
  }
}

TEST(SourceClock, ASlowSourceIsMeasuredByItsArrivalsToo) {
  for (const double by : {874.0, -25.0, -8.0, 12.0, -86400.0}) {
    Source source;
    for (int t = 0; t <= 600; t += 10) source.live(t + (t > 200 ? by : 0.0), t + 0.3 * (t % 7));
    EXPECT_NEAR(source.times.back(), 600.0, 11.0) << by;
    EXPECT_EQ(source.jumps.size(), 1u) << by;
  }
}

/// A jump while the network was away: the stamps are ahead of their arrival.
TEST(SourceClock, NoPauseHidesAJumpIntoTheFuture) {
  Source source;
  for (int t = 0; t <= 20; ++t) source.live(t, t);
  for (int t = 80; t <= 100; ++t) source.live(t + 874, t);
  EXPECT_NEAR(source.times.back(), 100.0, 1e-9);
  EXPECT_EQ(source.jumps.size(), 1u);
}

TEST(SourceClock, LinesThatWereHeldUpAreNoJump) {
  Source source;
  for (int t = 0; t <= 20; ++t) source.live(t, t);
  for (int t = 21; t <= 50; ++t) source.live(t, 50.0 + 1e-3 * t);  // the network was away
  for (int t = 51; t <= 70; ++t) source.live(t, t);
  for (int t = 171; t <= 200; ++t) source.live(t, t);  // the logger was off
  for (int t = 201; t <= 240; ++t) source.live(t, t + (t % 10 == 0 ? 3.0 : 0.0));
  EXPECT_THAT(source.jumps, IsEmpty());
  EXPECT_EQ(source.earlier, 0);
  EXPECT_EQ(source.times.back(), 240.0);
}

TEST(SourceClock, ASourceThatIsFasterThanRealTimeIsReadLikeAFile) {
  Source source;
  for (int t = 0; t <= 100; ++t) source.live(t + (t > 50 ? 874.0 : 0.0), 0.02 * t);
  EXPECT_EQ(source.times.back(), 100.0);
  EXPECT_THAT(source.jumps, ElementsAre(HasSubstr("--jump-from \"876 s\"")));
}

TEST(SourceClock, AFileHasGapsAndJumpsByTheirLength) {
  for (const auto& [by, is_jump] : {std::pair{874.0, true}, {61.0, true}, {45.0, false}}) {
    Source source;
    for (int t = 0; t <= 60; ++t) source.read(t + (t > 20 ? by : 0.0));
    EXPECT_EQ(source.times.back(), is_jump ? 60.0 : 60.0 + by);
    EXPECT_THAT(is_jump ? source.jumps : source.gaps, ElementsAre(HasSubstr("--jump-from")));
  }

  Source otherwise(1000.0), minute(30.0);
  for (int t = 0; t <= 60; ++t) {
    otherwise.read(t + (t > 20 ? 874.0 : 0.0));
    minute.read(t + (t > 20 ? 45.0 : 0.0));
  }
  EXPECT_EQ(otherwise.times.back(), 934.0);
  EXPECT_EQ(minute.times.back(), 60.0);

  Source slow;  // ten usual pauses are a usual gap
  for (int t = 0; t <= 600; t += 30) slow.read(t + (t > 300 ? 200.0 : 0.0));
  EXPECT_EQ(slow.times.back(), 800.0);
}

TEST(SourceClock, AStepBackIsAJumpWhereTheLinesGoOnFromThere) {
  for (const double by : {-60.0, -2.0, -7.5, -86400.0, -3600.0}) {
    Source source;
    for (int t = 0; t <= 60; ++t) source.read(t + (t > 40 ? by : 0.0));
    EXPECT_EQ(source.times.back(), 60.0) << by;
    EXPECT_EQ(source.earlier, 1) << by;
    EXPECT_THAT(source.jumps, ElementsAre(HasSubstr("was set back"))) << by;
  }
}

TEST(SourceClock, LateAndDoubledLinesAreLeftOut) {
  Source late;
  for (const double t : {0, 1, 2, 3, 4, 5, 8, 6, 7, 9, 10, 13, 12, 11, 14}) late.read(t);
  EXPECT_EQ(late.earlier, 4);
  EXPECT_THAT(late.jumps, IsEmpty());

  Source doubled;
  for (const int t : {0, 1, 2, 3, 4, 5, 6, 3, 4, 5, 6, 7, 8})
    doubled.repeat(t, static_cast<std::size_t>(t));
  EXPECT_EQ(doubled.earlier, 4);
  EXPECT_THAT(doubled.jumps, IsEmpty());
  EXPECT_EQ(doubled.times.back(), 8.0);
}

TEST(SourceClock, EachJumpIsFound) {
  Source source;
  double by = 0.0;
  for (int t = 0; t <= 300; ++t) {
    if (t % 100 == 50) by += t == 150 ? -500.0 : 874.0;
    source.live(t + by, t);
  }
  EXPECT_EQ(source.jumps.size(), 3u);
  EXPECT_NEAR(source.times.back(), 300.0, 1e-9);
}

/// A program that is started anew reads on where the source is, or the whole file again.
TEST(SourceClock, JumpsOfAnEarlierProgramAreKnown) {
  for (const double by : {874.0, -60.0, -8.0}) {
    const auto stamp = [&](int t) { return t + (t > 100 ? by : 0.0); };
    Source before;
    for (int t = 0; t <= 130; ++t) before.read(stamp(t));
    ASSERT_EQ(before.history().jumps.size(), 1u) << by;
    const double last_s = before.times.back();

    Source behind(before.history());
    for (int t = 131; t <= 140; ++t) behind.read(stamp(t));
    EXPECT_NEAR(behind.times.front(), last_s + 1.0, 1e-9) << by;
    EXPECT_NEAR(behind.times.back(), last_s + 10.0, 1e-9) << by;

    Source again(before.history());
    for (int t = 0; t <= 140; ++t) again.read(stamp(t));
    EXPECT_NEAR(again.times[50], 50.0, 1e-9) << by;
    EXPECT_NEAR(again.times.back(), last_s + 10.0, 1e-9) << by;
    EXPECT_THAT(again.jumps, IsEmpty()) << by;
  }
}

/// A log that was begun anew before the jump is read from its own first line.
TEST(SourceClock, AnotherFirstLineBeforeTheJumpIsBeforeIt) {
  Source before;
  for (int t = 0; t <= 130; ++t) before.read(t + (t > 100 ? 874.0 : 0.0));
  Source again(before.history());
  for (int t = 70; t <= 140; ++t) again.repeat(t + (t > 100 ? 874.0 : 0.0), 1001 + t);
  EXPECT_EQ(again.times.front(), 70.0);
  EXPECT_NEAR(again.times.back(), before.times.back() + 10.0, 1e-9);
}

TEST(SourceClock, AJumpAfterAKnownOneIsFoundAndAddsToIt) {
  Source before;
  for (int t = 0; t <= 130; ++t) before.read(t + (t > 100 ? 874.0 : 0.0));
  Source behind(before.history());
  for (int t = 131; t <= 200; ++t) behind.read(t + (t > 160 ? 2000.0 : 874.0));
  EXPECT_NEAR(behind.times.back(), 200.0, 1e-9);
  EXPECT_EQ(behind.jumps.size(), 1u);
  ASSERT_EQ(behind.history().jumps.size(), 2u);
  EXPECT_NEAR(behind.history().jumps.back().offset_s, -2000.0, 1e-9);
}

}  // namespace
}  // namespace dccast::client
