#include "core/base/tensors.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace dccast {
namespace {

TEST(SymmetricTensor, KeepsTheOutOfPlaneComponentInDeviatorAndNorm) {
  const SymmetricTensor<2> t{{1.0, 2.0, 6.0, 4.0}};
  EXPECT_DOUBLE_EQ(t.trace(), 9.0);
  const auto d = t.deviator();
  EXPECT_DOUBLE_EQ(d[0], -2.0);
  EXPECT_DOUBLE_EQ(d[1], -1.0);
  EXPECT_DOUBLE_EQ(d[2], 3.0);
  EXPECT_DOUBLE_EQ(d[3], 4.0);
  EXPECT_DOUBLE_EQ(d.trace(), 0.0);
  // Off-diagonal components count twice.
  EXPECT_DOUBLE_EQ(t.norm(), std::sqrt(1.0 + 4.0 + 36.0 + 2.0 * 16.0));
}

TEST(SymmetricTensor, NormIsThatOfTheFullMatrix) {
  const SymmetricTensor<3> t{{1.0, -2.0, 3.0, 0.5, -0.25, 4.0}};
  double sum = 0.0;
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) {
      EXPECT_EQ(t.at(a, b), t.at(b, a));
      sum += t.at(a, b) * t.at(a, b);
    }
  }
  EXPECT_DOUBLE_EQ(t.norm(), std::sqrt(sum));
  EXPECT_EQ(t.at(0, 1), 0.5);
  EXPECT_EQ(t.at(1, 2), -0.25);
  EXPECT_EQ(t.at(0, 2), 4.0);
}

TEST(SymmetricTensor, Adds) {
  SymmetricTensor<2> t{{1.0, 2.0, 3.0, 4.0}};
  t.add(2.0, SymmetricTensor<2>{{1.0, 0.0, -1.0, 0.5}}).add_identity(-1.0);
  EXPECT_EQ(t.value, (std::array{2.0, 1.0, 0.0, 5.0}));
}

}  // namespace
}  // namespace dccast
