#include "core/base/instructions.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace dccast {
namespace {

TEST(Lanes, WorkIsDoneWithAsManyNumbersAsARegisterHolds) {
  int count = 0;
  with_lanes([&]<int Count>() { count = Count; });
  EXPECT_EQ(count, register_lanes());
  EXPECT_LE(count, most_lanes);
}

TEST(Lanes, EveryLaneIsANumberOfItsOwn) {
  std::array<double, most_lanes> x, roots, halves;
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = double(i * i);
  with_lanes([&]<int Count>() {
    for (std::size_t i = 0; i < x.size(); i += Count) {
      const auto lanes = load<Count>(&x[i]);
      store<Count>(root<Count>(lanes), &roots[i]);
      store<Count>(lanes > 4.0 ? 0.5 * lanes : lanes, &halves[i]);
    }
  });
  for (std::size_t i = 0; i < x.size(); ++i) {
    EXPECT_EQ(roots[i], double(i));
    EXPECT_EQ(halves[i], i > 2 ? 0.5 * x[i] : x[i]);
  }
}

TEST(Lanes, AnyFindsOneLaneOfSeveral) {
  with_lanes([]<int Count>() {
    Lanes<Count> x{};
    EXPECT_FALSE(any<Count>(x > 0.0));
    x[Count - 1] = 1.0;
    EXPECT_TRUE(any<Count>(x > 0.0));
    x[Count - 1] = NAN;
    EXPECT_FALSE(any<Count>(x > 0.0));
  });
}

}  // namespace
}  // namespace dccast
