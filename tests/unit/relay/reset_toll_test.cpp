#include "server/relay/reset_toll.hpp"

#include <gtest/gtest.h>

namespace dccast::relay {
namespace {

using namespace std::chrono_literals;

TEST(ResetToll, SomeAreFreeAndEachFurtherOneIsPaidFor) {
  ResetToll toll;
  const auto now = ResetToll::Clock::now();
  toll.charge("192.0.2.1", ResetToll::free_at_once, now);
  EXPECT_LE(toll.paid_at("192.0.2.1"), now);
  toll.charge("192.0.2.1", 10, now);
  EXPECT_EQ(toll.paid_at("192.0.2.1"), now + 10 * ResetToll::of_each);
  EXPECT_LE(toll.paid_at("192.0.2.2"), now) << "another pays nothing";
}

TEST(ResetToll, HasAnEndAndIsForgotten) {
  ResetToll toll;
  const auto now = ResetToll::Clock::now();
  toll.charge("user id 7", 1'000'000, now);
  EXPECT_EQ(toll.paid_at("user id 7"), now + ResetToll::longest_wait);

  toll.charge("user id 8", 1, now + 10s);
  EXPECT_EQ(toll.paid_at("user id 7"), ResetToll::Clock::time_point());
  toll.charge("user id 7", ResetToll::free_at_once, now + 20s);
  EXPECT_LE(toll.paid_at("user id 7"), now + 20s) << "after a pause some are free again";
  EXPECT_FALSE(toll.is_empty());
}

}  // namespace
}  // namespace dccast::relay
