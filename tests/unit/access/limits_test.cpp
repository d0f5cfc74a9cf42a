#include "server/access/limits.hpp"

#include <gtest/gtest.h>

#include "proto/refusal/refusal.hpp"

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

/// The message of the refusal; empty where one more is permitted.
std::string refusal_of(OpenCount& open, const std::string& who) {
  try {
    open.enter(who, "streams");
    return "";
  } catch (const refusal::LimitReached& limit) {
    EXPECT_EQ(limit.facts().reason, v1::ErrorInfo::LIMIT_REACHED);
    return limit.what();
  }
}

TEST(OpenCount, NamesTheLimitItsValueAndWhoseItIs) {
  OpenCount open(3, 2);
  EXPECT_EQ(refusal_of(open, "anna"), "");
  EXPECT_EQ(refusal_of(open, "anna"), "");
  EXPECT_EQ(refusal_of(open, "anna"),
            "anna has 2 streams open; per_user.maximum_streams = 2; end one, then try again");
  EXPECT_EQ(refusal_of(open, "bert"), "");
  EXPECT_EQ(refusal_of(open, "carl"),
            "3 streams of all users are open; limits.maximum_streams = 3; end one, then try again");
  open.leave("anna");
  EXPECT_EQ(refusal_of(open, "carl"), "");
}

TEST(OpenCount, AUserWhoLeftIsForgotten) {
  OpenCount open(1, 1);
  open.leave("anna");
  EXPECT_EQ(refusal_of(open, "anna"), "");
  open.leave("anna");
  open.leave("anna");
  EXPECT_EQ(refusal_of(open, "bert"), "");
}

}  // namespace
}  // namespace dccast::access
