#include "proto/frames/contraction.hpp"

#include <gtest/gtest.h>

namespace dccast::frames {
namespace {

TEST(CurveValue, IsLinearBetweenThePointsAndConstantOutside) {
  v1::Curve curve;
  for (const double at : {1.0, 2.0, 4.0}) {
    curve.add_at(at);
    curve.add_value(10.0 * at);
  }
  EXPECT_EQ(curve_value(curve, 0.0), 10.0);
  EXPECT_EQ(curve_value(curve, 1.0), 10.0);
  EXPECT_DOUBLE_EQ(curve_value(curve, 2.5), 25.0);
  EXPECT_EQ(curve_value(curve, 9.0), 40.0);
}

TEST(CurveValue, WithoutPlacesIsConstant) {
  v1::Curve curve;
  curve.add_value(3.0);
  EXPECT_EQ(curve_value(curve, -7.0), 3.0);
}

}  // namespace
}  // namespace dccast::frames
