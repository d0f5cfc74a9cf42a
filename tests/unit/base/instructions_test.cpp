#include "core/base/instructions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

namespace dccast {
namespace {

TEST(InstructionsAskedFor, NeverGoBeyondTheProcessor) {
  const Instructions widest = processor_instructions();
  EXPECT_EQ(instructions_for(nullptr), widest);
  EXPECT_EQ(instructions_for(""), widest);
  EXPECT_EQ(instructions_for("plain"), Instructions::plain);
  EXPECT_EQ(instructions_for("avx2"), std::min(widest, Instructions::avx2));
  EXPECT_EQ(instructions_for("avx512"), std::min(widest, Instructions::avx512));
}

TEST(InstructionsAskedFor, AreRefusedByAnotherName) {
  EXPECT_THROW(instructions_for("sse"), std::invalid_argument);
}

TEST(Instructions, SetTheNumberOfLanes) {
  const Instructions in_use = instructions();
  EXPECT_EQ(register_lanes(), in_use == Instructions::plain  ? 2
                              : in_use == Instructions::avx2 ? 4
                                                             : 8);
}

}  // namespace
}  // namespace dccast
