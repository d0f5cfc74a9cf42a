#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "server/translate/translate.hpp"

namespace dccast::translate {
namespace {

constexpr std::array slopes{10.0, 20.0, 40.0};  // [K/m]

double linear_temperature(const std::vector<double>& point) {
  double temperature = 100.0;
  for (std::size_t axis = 0; axis < point.size(); ++axis) temperature += slopes[axis] * point[axis];
  return temperature;
}

/// One element with a linear temperature, that moves by its own x and bears a stress of 3 MPa.
results::Frame linear_frame(const std::vector<std::vector<double>>& nodes) {
  results::Frame frame;
  frame.time = 12.0;
  frame.dimension = static_cast<int>(nodes.front().size());
  frame.nodes_per_element = static_cast<int>(nodes.size());
  for (const auto& node : nodes) {
    frame.element_node.push_back(static_cast<int>(frame.temperature.size()));
    frame.temperature.push_back(linear_temperature(node));
    for (std::size_t axis = 0; axis < node.size(); ++axis) {
      frame.node.push_back(node[axis]);
      frame.displacement.push_back(axis == 0 ? node[0] : 0.0);
    }
  }
  frame.stress.assign(std::size_t(results::tensor_components(frame.dimension)), 0.0);
  frame.stress[0] = 3e6;
  return frame;
}

v1::ProbeResultRequest request_for(const std::vector<std::vector<double>>& points) {
  v1::ProbeResultRequest request;
  for (const auto& point : points)
    request.add_points()->mutable_coordinate_m()->Add(point.begin(), point.end());
  return request;
}

void expect_linear(const results::Frame& frame, const std::vector<double>& inside,
                   const std::vector<double>& outside) {
  v1::ProbeResultResponse found;
  add_probed(frame, request_for({inside, outside}), found);

  const int fields = 1 + frame.dimension;
  ASSERT_EQ(found.fields_size(), fields);
  ASSERT_EQ(found.instants_size(), 1);
  const auto& values = found.instants(0).values();
  ASSERT_EQ(values.size(), 2 * fields);
  EXPECT_NEAR(values[0], linear_temperature(inside), 1e-9);
  EXPECT_NEAR(values[1], inside[0], 1e-12);
  EXPECT_NEAR(values[2], 0.0, 1e-12);
  for (int i = fields; i < 2 * fields; ++i) EXPECT_TRUE(std::isnan(values[i])) << i;
}

TEST(AddProbed, EveryElementReproducesALinearField) {
  expect_linear(linear_frame({{0, 0}, {2, 0}, {0, 1}}), {0.5, 0.5}, {1.5, 0.9});
  expect_linear(linear_frame({{0, 0}, {2, 0.2}, {1.8, 1}, {0.1, 1.1}}), {0.9, 0.7}, {1.99, 0.95});
  expect_linear(linear_frame({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}), {0.2, 0.3, 0.1},
                {0.5, 0.5, 0.5});
  expect_linear(linear_frame({{0, 0, 0},
                              {1, 0.1, 0},
                              {1.1, 1, 0},
                              {0, 1, 0.1},
                              {0, 0, 1},
                              {1, 0, 1.2},
                              {1, 1, 1},
                              {0.1, 1, 1}}),
                {0.6, 0.4, 0.7}, {0.5, 0.5, 1.3});
}

TEST(AddProbed, FurtherFieldsFollowAndElementsHaveOneValue) {
  v1::ProbeResultRequest request = request_for({{0.2, 0.2}, {0.3, 0.1}});
  request.add_fields("von_mises_pa");
  v1::ProbeResultResponse found;
  add_probed(linear_frame({{0, 0}, {1, 0}, {1, 1}, {0, 1}}), request, found);

  ASSERT_EQ(found.fields_size(), 4);
  EXPECT_EQ(found.fields(3).name(), "von_mises_pa");
  EXPECT_EQ(found.fields(3).unit(), "Pa");
  EXPECT_NEAR(found.instants(0).values(3), 3e6, 1e-3);
  EXPECT_NEAR(found.instants(0).values(7), 3e6, 1e-3);
}

TEST(AddProbed, AFieldThatBeginsLaterIsNamedByTheFrameThatHasIt) {
  results::Frame frame = linear_frame({{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  v1::ProbeResultRequest request = request_for({{0.2, 0.2}});
  request.add_fields("von_mises_pa");

  results::Frame before = frame;
  before.stress.clear();
  v1::ProbeResultResponse found;
  add_probed(before, request, found);
  EXPECT_TRUE(found.fields(3).unit().empty());

  add_probed(frame, request, found);
  EXPECT_EQ(found.fields(3).unit(), "Pa");
  EXPECT_TRUE(std::isnan(found.instants(0).values(3)));
  EXPECT_NEAR(found.instants(1).values(3), 3e6, 1e-3);
}

}  // namespace
}  // namespace dccast::translate
