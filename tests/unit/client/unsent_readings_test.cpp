#include "client/session/unsent_readings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "tests/support/temporary_folder.hpp"

namespace dccast::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

std::vector<ReadingOfLine> readings_at(double begin_s, int count) {
  std::vector<ReadingOfLine> readings(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i)
    readings[static_cast<std::size_t>(i)].reading.set_time_s(begin_s + i);
  return readings;
}

class UnsentReadingsTest : public ::testing::Test {
protected:
  Remark remark() {
    return [this](const std::string& text) { remarks_.push_back(text); };
  }

  const TemporaryFolder folder_;
  const std::filesystem::path file_ = folder_.path() / "readings" / "job";
  std::vector<std::string> remarks_;
};

TEST_F(UnsentReadingsTest, GivesTheOldestThousandAtMost) {
  for (const int count : {1, 2, 30, 999, 1000, 1001, 2500}) {
    UnsentReadings unsent(file_, remark());
    ASSERT_TRUE(unsent.add(readings_at(0.0, count), {}));
    unsent.close();

    double next_s = 0.0;
    for (auto some = unsent.next({}); !some.empty(); some = unsent.next({})) {
      EXPECT_EQ(some.front().reading.time_s(), next_s);
      EXPECT_EQ(some.size(), static_cast<std::size_t>(std::min(1000.0, count - next_s)));
      next_s += static_cast<double>(some.size());
      unsent.acknowledge(some.size());
    }
    EXPECT_EQ(next_s, count);
    EXPECT_THAT(unsent, SizeIs(0));
  }
  EXPECT_FALSE(std::filesystem::exists(file_));
  EXPECT_THAT(remarks_, IsEmpty());
}

TEST_F(UnsentReadingsTest, WhatIsNotAcknowledgedIsSentByTheNextProgram) {
  {
    UnsentReadings unsent(file_, remark());
    ASSERT_TRUE(unsent.add(readings_at(0.0, 3), {}));
  }
  UnsentReadings unsent(file_, remark());
  EXPECT_THAT(remarks_, ElementsAre(HasSubstr("3 readings were kept in ")));
  const auto left = unsent.next({});
  ASSERT_THAT(left, SizeIs(3));
  EXPECT_EQ(left.back().reading.time_s(), 2.0);
}

}  // namespace
}  // namespace dccast::client
