#include "server/jobs/executors/precedence.hpp"

#include <gtest/gtest.h>

#include <map>

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

class PrecedenceTest : public testing::Test {
protected:
  Precedence::Registration enter(Urgency urgency, const std::string& name) {
    return precedence_.enter(urgency, 3.0, [this, name](const auto& stopped_for) {
      stopped_[name] = stopped_for.has_value();
      if (stopped_for) reason_ = stopped_for->description();
    });
  }

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

}  // namespace
}  // namespace dccast::jobs
