#include "core/base/curve.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

namespace dccast {
namespace {

const Curve table{Abscissa::temperature, {1.0, 3.0, 4.0}, {10.0, 20.0, 0.0}};

TEST(Curve, IsLinearInsideAndConstantOutside) {
  EXPECT_EQ(table(0.0), 10.0);
  EXPECT_EQ(table(1.0), 10.0);
  EXPECT_DOUBLE_EQ(table(1.5), 12.5);
  EXPECT_EQ(table(3.0), 20.0);
  EXPECT_DOUBLE_EQ(table(3.75), 5.0);
  EXPECT_EQ(table(4.0), 0.0);
  EXPECT_EQ(table(400.0), 0.0);
}

TEST(Curve, AFaultyTableIsNotReadBeyondItsEnds) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Curve point{Abscissa::distance, {nan}, {2.0}};
  EXPECT_EQ(point(1.0), 2.0);
  EXPECT_EQ(point.derivative(1.0), 0.0);
  EXPECT_EQ(point.integral(0.0, 1.0), 2.0);

  EXPECT_EQ(table(nan), 10.0);
  EXPECT_EQ(table.derivative(nan), 0.0);
  const Curve open{Abscissa::distance, {0.0, 1.0, nan}, {3.0, 4.0, 5.0}};
  EXPECT_EQ(open(2.0), 5.0);
  EXPECT_EQ(open.derivative(2.0), 0.0);
}

TEST(Curve, DerivativeBelongsToTheIntervalOnTheRight) {
  EXPECT_EQ(table.derivative(0.999), 0.0);
  EXPECT_DOUBLE_EQ(table.derivative(1.0), 5.0);
  EXPECT_DOUBLE_EQ(table.derivative(2.9), 5.0);
  EXPECT_DOUBLE_EQ(table.derivative(3.0), -20.0);
  EXPECT_EQ(table.derivative(4.0), 0.0);
}

TEST(Curve, IntegralIsExactAcrossPointsAndEnds) {
  EXPECT_DOUBLE_EQ(table.integral(1.0, 4.0), 30.0 + 10.0);
  EXPECT_DOUBLE_EQ(table.integral(0.0, 1.0), 10.0);
  EXPECT_DOUBLE_EQ(table.integral(-1.0, 5.0), 20.0 + 40.0);
  EXPECT_DOUBLE_EQ(table.integral(2.0, 3.5), 17.5 + 7.5);
  EXPECT_DOUBLE_EQ(table.integral(3.5, 2.0), -25.0);
  EXPECT_EQ(table.integral(2.0, 2.0), 0.0);
  EXPECT_EQ(table.integral(6.0, 9.0), 0.0);
}

/// The parts of an interval give the whole, wherever it is cut.
TEST(Curve, IntegralsAddUp) {
  for (int i = 0; i <= 60; ++i) {
    const double cut = -1.0 + 0.1 * i;
    EXPECT_NEAR(table.integral(-1.0, cut) + table.integral(cut, 5.0), 60.0, 1e-12) << cut;
  }
}

TEST(Curve, AConstantIsOneEverywhere) {
  const Curve constant(7.0);
  EXPECT_TRUE(constant.constant());
  EXPECT_EQ(constant(-1e9), 7.0);
  EXPECT_EQ(constant(1e9), 7.0);
  EXPECT_EQ(constant.derivative(0.0), 0.0);
  EXPECT_DOUBLE_EQ(constant.integral(-2.0, 3.0), 35.0);
}

TEST(Curve, TellsItselfApart) {
  EXPECT_TRUE(Curve{}.empty());
  EXPECT_FALSE(table.empty());
  EXPECT_FALSE(table.constant());
  EXPECT_EQ(table.abscissa(), Abscissa::temperature);
  EXPECT_THROW((Curve{Abscissa::time, {0.0, 1.0}, {1.0}}), std::logic_error);
}

}  // namespace
}  // namespace dccast
