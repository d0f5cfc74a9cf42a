#include "core/results/journal.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "tests/unit/results/sample_run.hpp"

namespace dccast::results {
namespace {

TEST(RunRecords, KeepHeaderAndFrame) {
  EXPECT_EQ(read_header(to_sections(sample_header())), sample_header());
  EXPECT_EQ(read_frame(to_sections(sample_frame(3, 4, 5))), sample_frame(3, 4, 5));
}

TEST(RunRecords, KeepTheThirdDimension) {
  EXPECT_EQ(read_header(to_sections(sample_solid_header())), sample_solid_header());
  EXPECT_EQ(read_frame(to_sections(sample_solid_frame(3, 2))), sample_solid_frame(3, 2));
}

TEST(RunRecords, OfOtherSoftwareAreRefused) {
  EXPECT_THROW(read_header({}), std::out_of_range);
  EXPECT_THROW(read_frame({}), std::out_of_range);
}

}  // namespace
}  // namespace dccast::results
