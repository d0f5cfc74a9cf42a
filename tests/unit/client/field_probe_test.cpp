#include "client/model/field_probe.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace dccast::client {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;

/// A frame of one element whose temperature is 100 + 10 x + 20 y + 40 z, with x as displacement.
v1::Frame linear_frame(int dimension, const std::vector<std::vector<double>>& nodes) {
  v1::Frame frame;
  frame.set_dimension(dimension);
  frame.set_nodes_per_element(static_cast<int>(nodes.size()));
  for (const auto& node : nodes) {
    double temperature = 100.0;
    for (int axis = 0; axis < dimension; ++axis) {
      constexpr std::array slopes{10.0, 20.0, 40.0};
      temperature += slopes[std::size_t(axis)] * node[std::size_t(axis)];
      frame.add_node_m(node[std::size_t(axis)]);
      frame.add_displacement_m(axis == 0 ? node[0] : 0.0);
    }
    frame.add_element_node(frame.temperature_c_size());
    frame.add_temperature_c(temperature);
  }
  return frame;
}

void expect_linear(const v1::Frame& frame, const std::vector<double>& inside,
                   const std::vector<double>& outside) {
  const auto values = values_at(frame, inside);
  ASSERT_TRUE(values.has_value());
  double expected = 100.0;
  constexpr std::array slopes{10.0, 20.0, 40.0};
  for (std::size_t axis = 0; axis < inside.size(); ++axis) expected += slopes[axis] * inside[axis];
  EXPECT_NEAR(values->temperature_c, expected, 1e-9);
  EXPECT_NEAR(values->displacement_m[0], inside[0], 1e-12);
  EXPECT_FALSE(values_at(frame, outside).has_value());
}

TEST(FieldProbe, EveryElementReproducesALinearField) {
  expect_linear(linear_frame(2, {{0, 0}, {2, 0}, {0, 1}}), {0.5, 0.5}, {1.5, 0.9});
  expect_linear(linear_frame(2, {{0, 0}, {2, 0.2}, {1.8, 1}, {0.1, 1.1}}), {0.9, 0.7},
                {1.99, 0.95});
  expect_linear(linear_frame(3, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}), {0.2, 0.3, 0.1},
                {0.5, 0.5, 0.5});
  expect_linear(linear_frame(3, {{0, 0, 0},
                                 {1, 0.1, 0},
                                 {1.1, 1, 0},
                                 {0, 1, 0.1},
                                 {0, 0, 1},
                                 {1, 0, 1.2},
                                 {1, 1, 1},
                                 {0.1, 1, 1}}),
                {0.6, 0.4, 0.7}, {0.5, 0.5, 1.3});
}

TEST(FieldProbe, PointsOnTheBoundaryBelongToTheMetal) {
  const v1::Frame square = linear_frame(2, {{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  for (const auto& point : {std::vector{0.0, 0.0}, {1.0, 1.0}, {0.5, 1.0}})
    EXPECT_TRUE(values_at(square, point).has_value());
  EXPECT_FALSE(values_at(square, {0.5, 1.001}).has_value());
  EXPECT_FALSE(values_at(square, {0.5, 0.5, 0.5}).has_value()) << "another dimension";
}

TEST(FieldProbe, AnInconsistentFrameHasNoValues) {
  v1::Frame frame = linear_frame(2, {{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  frame.set_element_node(2, 7);
  EXPECT_FALSE(values_at(frame, {0.5, 0.5}).has_value());
}

TEST(FieldProbe, ALineHasBothItsEnds) {
  const auto points = points_on_line({0.0, 1.0}, {1.0, 3.0}, 3);
  EXPECT_THAT(points, ElementsAre(ElementsAre(0.0, 1.0), ElementsAre(0.5, 2.0),
                                  ElementsAre(DoubleNear(1.0, 1e-12), DoubleNear(3.0, 1e-12))));
}

}  // namespace
}  // namespace dccast::client
