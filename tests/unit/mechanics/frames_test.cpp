#include <gtest/gtest.h>

#include "tests/unit/mechanics/bodies.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

/// A frame turned about the vertical.
NodalFrame<3> turned_frame(int node, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {node, {{{c, s, 0.0}, {-s, c, 0.0}, {0.0, 0.0, 1.0}}}};
}

template <class Element>
std::vector<int> nodes_on(const FixedBody<Element>& body, const char* patch) {
  return mesh::patch_nodes(*body.mesh.find(patch));
}

template <class Element>
class FramesOn : public ::testing::Test {
protected:
  static mesh::Mesh3D shape() { return distorted_box<Element>({0.3, 0.2, 0.25}, {3, 2, 2}); }
  static std::vector<NodalFrame<3>> some_frames(const mesh::Mesh3D& box) {
    std::vector<NodalFrame<3>> frames;
    for (int n : mesh::patch_nodes(face(box, 0, 1.0)))
      frames.push_back(turned_frame(n, 0.3 + 0.1 * n));
    return frames;
  }
  /// Creeps under its weight, held below and at one side.
  static void load(FixedBody<Element>& body) {
    body.set_material(1e9, 0.35, 1e-35);
    for (int n : nodes_on(body, "z_low")) body.fix(n, {0.0, 0.0, 0.0});
    hold_low_end(body, 0);
    const std::vector<double> weight(body.forms.elements(), 1e7);
    body.forms.subtract_weight(weight, body.problem.external_force);
  }
};
TYPED_TEST_SUITE(FramesOn, SolidFamilies);

/// The frame of a node changes how its unknowns are written and nothing else.
TYPED_TEST(FramesOn, ChangeNothingButTheUnknowns) {
  FixedBody<TypeParam> plain(this->shape()), framed(this->shape());
  const auto frames = this->some_frames(framed.mesh);
  framed.forms.set_frames(frames);
  this->load(plain);
  this->load(framed);
  const auto a = plain.step(tight(1e-12)), b = framed.step(tight(1e-12));

  ASSERT_TRUE(a.converged);
  ASSERT_TRUE(b.converged);
  EXPECT_EQ(a.iterations, b.iterations);

  double size = 0.0;
  for (double u : plain.displacement()) size = std::max(size, std::abs(u));
  std::vector<double> back = framed.displacement();
  for (const auto& frame : frames) {
    double* u = &back[3 * std::size_t(frame.node)];
    const Vector3 v = frame.to_coordinates({u[0], u[1], u[2]});
    std::copy(v.begin(), v.end(), u);
  }
  for (std::size_t i = 0; i < back.size(); ++i) {
    EXPECT_NEAR(back[i], plain.displacement()[i], 1e-11 * size);
  }

  const auto stress = plain.stresses();
  auto other = framed.stresses();
  for (std::size_t i = 0; i < stress.size(); ++i) {
    EXPECT_LE(other[i].add(-1.0, stress[i]).norm(), 1e-10 * 1e9 * size);
  }
}

/// A box turned about the vertical, its sides held along their normals: the box that is not turned.
TYPED_TEST(FramesOn, HoldAnObliqueFaceExactly) {
  constexpr double angle = 0.4;
  const auto place = [](const Vector3& s) { return Vector3{0.3 * s[0], 0.2 * s[1], 0.25 * s[2]}; };
  const auto turn = [&](const Vector3& x) {
    return Vector3{std::cos(angle) * x[0] - std::sin(angle) * x[1],
                   std::sin(angle) * x[0] + std::cos(angle) * x[1], x[2]};
  };

  constexpr bool tetrahedra = is_simplex<TypeParam>;
  FixedBody<TypeParam> straight(box_mesh({3, 2, 2}, tetrahedra, place));
  FixedBody<TypeParam> oblique(
      box_mesh({3, 2, 2}, tetrahedra, [&](const Vector3& s) { return turn(place(s)); }));

  // The oblique box is held along the normals of its turned faces.
  std::vector<NodalFrame<3>> frames;
  for (const char* name : {"x_low", "x_high", "y_low"}) {
    for (int n : nodes_on(oblique, name)) frames.push_back(turned_frame(n, angle));
  }
  oblique.forms.set_frames(frames);

  for (auto* body : {&straight, &oblique}) {
    body->set_material(1e9, 0.35);
    for (double& thermal : body->problem.thermal) thermal = 1e-2;
    for (int n : nodes_on(*body, "x_low")) body->fix(n, 0, 0.0);
    for (int n : nodes_on(*body, "x_high")) body->fix(n, 0, -1e-3);
    for (int n : nodes_on(*body, "y_low")) body->fix(n, 1, 0.0);
    for (int n : nodes_on(*body, "z_low")) body->fix(n, 2, 0.0);
    ASSERT_TRUE(body->step(tight(1e-12)).converged);
  }

  for (int n : nodes_on(straight, "x_high")) {
    for (int d = 0; d < 3; ++d) {
      EXPECT_NEAR(oblique.displacement(n, d), straight.displacement(n, d), 1e-14);
    }
  }
}

}  // namespace
}  // namespace dccast::mechanics
