#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "tests/unit/mechanics/slab_bench.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

/// A quarter slab of melt, whose sides are all held, seen through its supports.
class HeldSlab {
public:
  explicit HeldSlab(const Curve& half_thickness)
      : slab(quarter_section(mesh::ElementKind::q1_bending, half_thickness)) {
    forms.update(slab.mesh());
    supports.find(slab.mesh(), forms);
    problem.fixed.assign(3 * std::size_t(slab.mesh().nodes()), 0);
    problem.external_force.assign(problem.fixed.size(), 0.0);
    problem.target.assign(problem.fixed.size(), 0.0);
    const std::vector<char> of_body(std::size_t(slab.mesh().nodes()), 0);
    const std::vector<double> hot(std::size_t(slab.mesh().nodes()), 650.0);
    std::vector<char> closed;
    supports.place_on_block(problem, true, of_body);
    supports.hold_sides(problem, tight(1e-8), of_body, hot, 620.0, 0.0, problem.target,
                        problem.fixed, closed);
    for (const auto& frame : supports.frames()) frame_of[frame.node] = frame;
  }

  /// Horizontal directions along which the node at a place of the plan is held.
  std::vector<Vector3> held_at(double x, double y) const {
    std::vector<Vector3> held;
    const int n = node_at(x, y);
    for (std::size_t d = 0; d < 3; ++d) {
      if (problem.fixed[std::size_t(3 * n) + d] == 0) continue;
      Vector3 axis{};
      axis[d] = 1.0;
      const auto frame = frame_of.find(n);
      held.push_back(frame == frame_of.end() ? axis : frame->second.axis[d]);
    }
    return held;
  }
  int node_at(double x, double y) const {
    for (int n = 0; n < slab.nodes_per_row(); ++n) {
      const double* p = slab.mesh().point(n);
      if (std::hypot(p[0] - x, p[1] - y) < 1e-9) return n;
    }
    ADD_FAILURE() << "no node at " << x << ", " << y;
    return 0;
  }

  mesh::SlabMesh3D slab;
  FormsOf<fem::BendingHexahedron> forms;
  SlabSupports<3> supports;
  StepProblem<3> problem;
  std::map<int, NodalFrame<3>> frame_of;
};

TEST(SlabSupports, ARectangleNeedsNoFrames) {
  HeldSlab held(Curve(0.2));
  EXPECT_TRUE(held.supports.frames().empty());
  EXPECT_EQ(held.held_at(0.0, 0.2).size(), 2u);
  EXPECT_EQ(held.held_at(0.5, 0.2).size(), 2u);
  EXPECT_EQ(held.held_at(0.5, 0.0).size(), 2u);
  EXPECT_EQ(held.held_at(0.0, 0.0).size(), 2u);
  EXPECT_EQ(held.held_at(0.5, 0.0)[0], (Vector3{1.0, 0.0, 0.0}));
}

/// Two segments that meet at 10 degrees are one side: its mean normal holds, not both.
TEST(SlabSupports, SidesThatMeetAtASmallAngleHoldAlongTheirMeanNormal) {
  const double slope = std::tan(10.0 / 180.0 * M_PI);
  HeldSlab held(Curve(Abscissa::distance, {0.0, 0.3, 0.5}, {0.2, 0.2, 0.2 - 0.2 * slope}));
  const auto at_kink = held.held_at(0.3, 0.2);
  ASSERT_EQ(at_kink.size(), 1u);
  EXPECT_GT(at_kink[0][0], 0.05);
  EXPECT_LT(at_kink[0][0], std::sin(10.0 / 180.0 * M_PI));
  EXPECT_NEAR(std::hypot(at_kink[0][0], at_kink[0][1]), 1.0, 1e-15);
  // Where the plane x = 0 holds the node too, what is left of the normal is y.
  EXPECT_EQ(held.frame_of.count(held.node_at(0.0, 0.2)), 0u);
  EXPECT_EQ(held.held_at(0.0, 0.2).size(), 2u);
  EXPECT_EQ(held.held_at(0.5, 0.2 - 0.2 * slope).size(), 2u) << "the corner is held both ways";

  for (const auto& [node, frame] : held.frame_of) {
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = 0; b < 3; ++b) {
        double dot = 0.0;
        for (std::size_t d = 0; d < 3; ++d) dot += frame.axis[a][d] * frame.axis[b][d];
        EXPECT_NEAR(dot, a == b ? 1.0 : 0.0, 1e-15);
      }
    }
    EXPECT_EQ(frame.axis[2], (Vector3{0.0, 0.0, 1.0}));
  }
}

/// At 45 degrees they are two, and a node they share stays where it is.
TEST(SlabSupports, SidesThatMeetAtALargeAngleHoldBothWays) {
  HeldSlab held(Curve(Abscissa::distance, {0.0, 0.4, 0.5}, {0.2, 0.2, 0.1}));
  EXPECT_EQ(held.held_at(0.4, 0.2).size(), 2u);
}

}  // namespace
}  // namespace dccast::mechanics
