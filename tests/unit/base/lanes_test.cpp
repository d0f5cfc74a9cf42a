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

TEST(Lanes, PowersAreThoseOfEachNumber) {
  const std::array<double, most_lanes> x{0.0, 1e-9, 0.3, 1.0, 2.0, 3.7e7, 9.9e8, 1e12};
  for (const double exponent : {0.0, 0.25, 1.0, 2.3, 5.0}) {
    std::array<double, most_lanes> powers;
    with_lanes([&]<int Count>() {
      for (std::size_t i = 0; i < x.size(); i += Count)
        store<Count>(power<Count>(load<Count>(&x[i]), exponent), &powers[i]);
    });
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double expected = std::pow(x[i], exponent);
      EXPECT_NEAR(powers[i], expected, 1e-15 * expected) << x[i] << " to the " << exponent;
    }
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
