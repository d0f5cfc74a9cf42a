#include "server/relay/held_memory.hpp"

#include <gtest/gtest.h>

namespace dccast::relay {

namespace {

constexpr MemoryBounds bounds{.all = 96, .of_user = 80, .of_strangers = 32, .of_machine = 8};

std::optional<std::size_t> ended(const std::vector<HeldMemory>& connections) {
  return beyond_bounds(connections, bounds);
}

TEST(HeldMemory, WithinTheirBoundsAllGoOn) {
  EXPECT_EQ(ended({}), std::nullopt);
  EXPECT_EQ(ended({{"anna", "a", 64}, {"", "b", 8}, {"", "c", 8}, {"", "d", 8}, {"", "e", 8}}),
            std::nullopt);
}

TEST(HeldMemory, StrangersOfOneMachineAreBoundedFirst) {
  EXPECT_EQ(ended({{"anna", "a", 64}, {"", "b", 3}, {"", "b", 6}}), 2U);
}

TEST(HeldMemory, StrangersOfManyMachinesAreBoundedTogether) {
  std::vector<HeldMemory> connections{{"anna", "a", 64}};
  for (int machine = 0; machine < 5; ++machine)
    connections.push_back({"", std::to_string(machine), machine == 2 ? 8U : 7U});
  EXPECT_EQ(ended(connections), 3U);
}

TEST(HeldMemory, AUserIsBoundedOnAllMachinesTogether) {
  EXPECT_EQ(ended({{"mallory", "a", 41}, {"anna", "b", 1}, {"mallory", "c", 40}}), 0U);
}

TEST(HeldMemory, BeyondTheTotalTheUserWhoHoldsMostGivesWay) {
  EXPECT_EQ(ended({{"anna", "a", 33}, {"mallory", "b", 32}, {"mallory", "b", 33}}), 2U);
}

TEST(HeldMemory, NoUserIsNamedLikeAMachine) {
  EXPECT_EQ(ended({{"192.0.2.1", "a", 64}, {"", "192.0.2.1", 8}}), std::nullopt);
}

}  // namespace

}  // namespace dccast::relay
