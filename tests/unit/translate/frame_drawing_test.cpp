#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <map>
#include <set>

#include "server/translate/translate.hpp"
#include "tests/support/quarter_frame.hpp"

namespace dccast::translate {
namespace {

Eigen::Vector3d place(const v1::Frame& frame, int node) {
  return {frame.node_m(3 * node), frame.node_m(3 * node + 1), frame.node_m(3 * node + 2)};
}

/// Area of the triangles of the skin that face each direction of the axes, e.g. "-z" [m2].
std::map<std::string, double> skin_areas(const v1::Frame& frame) {
  std::map<std::string, double> areas;
  for (int i = 0; i < frame.skin_triangle_size(); i += 3) {
    const Eigen::Vector3d first = place(frame, frame.skin_triangle(i));
    const Eigen::Vector3d twice = (place(frame, frame.skin_triangle(i + 1)) - first)
                                      .cross(place(frame, frame.skin_triangle(i + 2)) - first);
    Eigen::Index axis = 0;
    twice.cwiseAbs().maxCoeff(&axis);
    const std::string name{twice[axis] < 0.0 ? '-' : '+', "xyz"[axis]};
    areas[name] += 0.5 * twice.norm();
  }
  return areas;
}

TEST(FrameDrawing, TheSkinOfASlabIsItsSurfaceSeenFromOutside) {
  v1::Frame frame = support::quarter_frame();
  make_drawing(frame);
  EXPECT_EQ(frame.skin_triangle_size(), 3 * 2 * 24);  // four faces a side

  const auto areas = skin_areas(frame);
  const std::map<std::string, double> expected{{"+x", 0.08}, {"-x", 0.08}, {"+y", 0.12},
                                               {"-y", 0.12}, {"+z", 0.24}, {"-z", 0.24}};
  ASSERT_EQ(areas.size(), expected.size());
  for (const auto& [name, area] : expected) EXPECT_NEAR(areas.at(name), area, 1e-12) << name;
  EXPECT_EQ(frame.skin_edge_size(), 2 * 24) << "twelve edges, each of two cells";
}

TEST(FrameDrawing, TheFaceBetweenTwoTetrahedraIsLeftOut) {
  v1::Frame frame;
  frame.set_dimension(3);
  frame.set_nodes_per_element(4);
  for (const double x : {0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1., 1., 1., 1.})
    frame.add_node_m(x);
  for (const int node : {0, 1, 2, 3, 1, 2, 3, 4}) frame.add_element_node(node);
  for (int i = 0; i < 5; ++i) frame.add_temperature_c(20.0 * i);
  make_drawing(frame);
  EXPECT_EQ(frame.skin_triangle_size(), 3 * 6);

  std::set<std::set<int>> faces;
  for (int i = 0; i < frame.skin_triangle_size(); i += 3)
    faces.insert({frame.skin_triangle(i), frame.skin_triangle(i + 1), frame.skin_triangle(i + 2)});
  EXPECT_EQ(faces.size(), 6u);
  EXPECT_FALSE(faces.contains({1, 2, 3}));
}

TEST(FrameDrawing, ASectionIsDrawnWholeWithItsRim) {
  v1::Frame frame;
  frame.set_dimension(2);
  frame.set_nodes_per_element(4);
  for (int row = 0; row < 2; ++row)
    for (int i = 0; i < 3; ++i) {
      frame.add_node_m(i);
      frame.add_node_m(row);
      frame.add_temperature_c(20.0);
    }
  for (const int node : {0, 1, 4, 3, 1, 2, 5, 4}) frame.add_element_node(node);
  make_drawing(frame);
  EXPECT_EQ(frame.skin_triangle_size(), 3 * 4);
  EXPECT_EQ(frame.skin_edge_size(), 2 * 6) << "the edge between both cells is no rim";
}

/// The metal level is level, and the liquid below it fills what the solid leaves.
TEST(FrameDrawing, LiquidStandsLevel) {
  v1::Frame frame = support::quarter_frame();
  frame.set_metal_level_m(0.2);
  for (int n = 0; n < 9; ++n)
    frame.set_temperature_c(9 + n, 640.0);  // only the lowest row is solid
  for (int n = 18; n < 27; ++n) frame.set_displacement_m(3 * n + 2, 0.05);
  v1::Frame drawn = frame;
  make_drawing(drawn);
  const auto up = [&](int n) { return drawn.displacement_m(3 * n + 2); };
  for (int n = 18; n < 27; ++n) EXPECT_EQ(up(n), 0.0) << n;

  EXPECT_EQ(up(8), 20e-3) << "the corner of the butt has risen";
  EXPECT_NEAR(up(17), 10e-3, 1e-15) << "half way from the front to the level";
  EXPECT_EQ(drawn.displacement_m(3 * 17 + 1), -4e-3) << "what moves sideways is what the mesh has";

  for (int n = 0; n < 9; ++n) frame.set_temperature_c(n, 640.0);
  make_drawing(frame);
  for (int i = 2; i < frame.displacement_m_size(); i += 3) EXPECT_EQ(frame.displacement_m(i), 0.0);
}

}  // namespace
}  // namespace dccast::translate
