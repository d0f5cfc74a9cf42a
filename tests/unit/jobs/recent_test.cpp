#include "server/jobs/recent.hpp"

#include <gtest/gtest.h>

namespace dccast::jobs {
namespace {

std::shared_ptr<const int> number(int value) {
  return std::make_shared<const int>(value);
}

TEST(Recent, WhatWasAskedForLongestAgoIsDroppedFirst) {
  Recent<const int> recent(100);
  recent.keep("a", number(1), 40);
  recent.keep("b", number(2), 40);
  EXPECT_EQ(*recent.find("a"), 1);
  recent.keep("c", number(3), 30);
  EXPECT_EQ(recent.find("b"), nullptr);
  EXPECT_EQ(*recent.find("a"), 1);
  EXPECT_EQ(*recent.find("c"), 3);
}

TEST(Recent, WhatIsLargerThanAllIsNotKeptAndDropsNothing) {
  Recent<const int> recent(100);
  recent.keep("a", number(1), 100);
  EXPECT_EQ(*recent.keep("b", number(2), 101), 2);
  EXPECT_EQ(recent.find("b"), nullptr);
  EXPECT_EQ(*recent.find("a"), 1);
}

TEST(Recent, TheFirstUnderANameStays) {
  Recent<const int> recent(2);
  recent.keep("a", number(1));
  EXPECT_EQ(*recent.keep("a", number(2)), 1);
  recent.keep("b", number(3));
  EXPECT_EQ(*recent.find("a"), 1) << "it has been counted twice";
}

TEST(Recent, WhatIsForgottenGivesItsRoom) {
  Recent<const int> recent(100);
  recent.keep("a", number(1), 60);
  recent.keep("b", number(2), 40);
  recent.forget("a");
  recent.forget("never kept");
  EXPECT_EQ(recent.find("a"), nullptr);
  recent.keep("c", number(3), 60);
  EXPECT_EQ(*recent.find("b"), 2);
}

}  // namespace
}  // namespace dccast::jobs
