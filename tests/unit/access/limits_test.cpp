#include "server/access/limits.hpp"

#include <gtest/gtest.h>

namespace dccast::access {
namespace {

using namespace std::chrono_literals;

TEST(CallRate, HoldsTenSecondsWorthAndFillsAgain) {
  CallRate rate(2.0);
  const CallRate::Time start{1000s};
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(rate.take("anna", start)) << i;
  EXPECT_FALSE(rate.take("anna", start));
  EXPECT_TRUE(rate.take("bert", start)) << "a bucket of its own";
  EXPECT_TRUE(rate.take("anna", start + 500ms));
  EXPECT_FALSE(rate.take("anna", start + 600ms));
}

TEST(CallRate, ForgetsThoseWhoHaveBeenQuiet) {
  CallRate rate(1.0);
  const CallRate::Time start{1000s};
  for (int i = 0; i < 25000; ++i)
    EXPECT_TRUE(rate.take(std::to_string(i), start + std::chrono::seconds(i)));
}

TEST(OpenCount, NamesTheLimitItsValueAndWhoseItIs) {
  OpenCount open(3, 2);
  EXPECT_EQ(open.enter("anna", "streams"), "");
  EXPECT_EQ(open.enter("anna", "streams"), "");
  EXPECT_EQ(open.enter("anna", "streams"), "anna has 2 streams open; maximum_streams_per_user = 2");
  EXPECT_EQ(open.enter("bert", "streams"), "");
  EXPECT_EQ(open.enter("carl", "streams"), "3 streams of all users are open; maximum_streams = 3");
  open.leave("anna");
  EXPECT_EQ(open.enter("carl", "streams"), "");
}

TEST(OpenCount, AUserWhoLeftIsForgotten) {
  OpenCount open(1, 1);
  open.leave("anna");
  EXPECT_EQ(open.enter("anna", "streams"), "");
  open.leave("anna");
  open.leave("anna");
  EXPECT_EQ(open.enter("bert", "streams"), "");
}

}  // namespace
}  // namespace dccast::access
