#include "server/jobs/executors/precedence.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <thread>

#include "tests/support/eventually.hpp"

namespace dccast::jobs {
namespace {

TEST(UrgencyOfAQuery, FollowsFromItsEstimateAndFromWhetherItIsOneOfSeveral) {
  EXPECT_EQ(classify_query(2.8, false), Urgency::quick);
  EXPECT_EQ(classify_query(9.1, false), Urgency::draft);
  EXPECT_EQ(classify_query(42.0, false), Urgency::long_query);
  EXPECT_EQ(classify_query(2.8, true), Urgency::comparison);
  EXPECT_EQ(classify_query(9.1, true), Urgency::comparison);
  EXPECT_EQ(classify_query(42.0, true), Urgency::long_query);
}

/// The processor time of a run that uses a whole processor from some time on.
struct Computes {
  std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();
  std::optional<double> operator()() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }
};

class PrecedenceTest : public testing::Test {
protected:
  Precedence::Registration enter(Urgency urgency, const std::string& name,
                                 std::function<std::optional<double>()> processor_s = Computes(),
                                 double estimated_s = 1000.0) {
    const auto on_change = [this, name](const auto& stopped_for) {
      const std::lock_guard lock(mutex_);
      stopped_[name] = stopped_for.has_value();
      if (stopped_for) reason_ = stopped_for->description();
    };
    return precedence_.enter({.urgency = urgency,
                              .estimated_s = estimated_s,
                              .on_change = on_change,
                              .processor_s = std::move(processor_s)});
  }
  bool is_stopped(const std::string& name) {
    const std::lock_guard lock(mutex_);
    return stopped_[name];
  }

  std::mutex mutex_;                     ///< the calls come from another thread, too
  std::map<std::string, bool> stopped_;  ///< of the runs that were stopped or continued
  std::string reason_;
  Precedence precedence_;
};

using Stopped = std::map<std::string, bool>;

TEST_F(PrecedenceTest, AQuickQueryStopsAllOthersUntilItEnds) {
  const auto job = enter(Urgency::batch, "job");
  const auto compared = enter(Urgency::comparison, "compared");
  const auto draft = enter(Urgency::draft, "draft");
  {
    const auto quick = enter(Urgency::quick, "quick");
    EXPECT_EQ(stopped_, (Stopped{{"job", true}, {"compared", true}, {"draft", true}}));
    EXPECT_EQ(reason_, "stopped while a more urgent query runs");
  }
  EXPECT_EQ(stopped_, (Stopped{{"job", true}, {"compared", true}, {"draft", false}}));
}

TEST_F(PrecedenceTest, EqualsDoNotStopEachOtherAndTheLastOneLetsTheOthersGoOn) {
  const auto job = enter(Urgency::batch, "job");
  auto first = enter(Urgency::quick, "first");
  auto second = enter(Urgency::quick, "second");
  first.leave();
  EXPECT_EQ(stopped_, (Stopped{{"job", true}}));
  second.leave();
  EXPECT_EQ(stopped_, (Stopped{{"job", false}}));
}

TEST_F(PrecedenceTest, LongQueriesAndComparisonsStopNoJob) {
  const auto job = enter(Urgency::batch, "job");
  const auto compared = enter(Urgency::comparison, "compared");
  const auto long_query = enter(Urgency::long_query, "long");
  EXPECT_EQ(stopped_, Stopped{});
}

TEST_F(PrecedenceTest, ARunThatBeginsBesideAMoreUrgentOneIsStoppedAtOnce) {
  const auto quick = enter(Urgency::quick, "quick");
  auto job = enter(Urgency::batch, "job");
  EXPECT_EQ(stopped_, (Stopped{{"job", true}}));
  job.leave();  // its worker may be used again
  EXPECT_EQ(stopped_, (Stopped{{"job", false}}));
}

TEST_F(PrecedenceTest, ARunThatWaitsStopsNoOneUntilItComputesAgain) {
  const auto job = enter(Urgency::batch, "job");
  std::atomic<bool> computes = false;
  double used_s = 0.0;
  const auto follower = enter(Urgency::quick, "follower", [&] {
    if (computes) used_s += 1.0;
    return std::optional(used_s);
  });
  EXPECT_TRUE(is_stopped("job"));
  EXPECT_TRUE(eventually([&] { return !is_stopped("job"); }));

  computes = true;
  EXPECT_TRUE(eventually([&] { return is_stopped("job"); }));
  computes = false;
  EXPECT_TRUE(eventually([&] { return !is_stopped("job"); }));
}

TEST_F(PrecedenceTest, PrecedenceEndsAfterTwiceTheEstimate) {
  const auto job = enter(Urgency::batch, "job");
  const auto draft = enter(Urgency::draft, "draft", Computes(), 0.2);
  EXPECT_TRUE(is_stopped("job"));
  EXPECT_TRUE(eventually([&] { return !is_stopped("job"); }));
  EXPECT_TRUE(stays([&] { return !is_stopped("job"); }, 3 * between_looks))
      << "it does not come back";

  const auto quick = enter(Urgency::quick, "quick");
  EXPECT_TRUE(is_stopped("job"));
  EXPECT_TRUE(is_stopped("draft")) << "it is stopped like any other";
}

TEST_F(PrecedenceTest, ARunWhoseUseIsNotKnownKeepsItsPrecedence) {
  const auto job = enter(Urgency::batch, "job");
  const auto quick = enter(Urgency::quick, "quick", [] { return std::nullopt; });
  EXPECT_TRUE(stays([&] { return is_stopped("job"); }, 3 * between_looks));
}

}  // namespace
}  // namespace dccast::jobs
