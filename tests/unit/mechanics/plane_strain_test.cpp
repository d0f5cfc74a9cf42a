#include <gtest/gtest.h>

#include "tests/unit/mechanics/bodies.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

template <class Plane, class Solid>
struct Extrusion {
  using Section = Plane;
  using Body = Solid;
};

/// A section one cell thick along y, held there: plane strain. Sections stand in x and z.
template <class Pair>
class ExtrusionOf : public ::testing::Test {
protected:
  using Plane = typename Pair::Section;
  using Solid = typename Pair::Body;
  static constexpr int columns = 5, rows = 4;
  static constexpr double width = 0.3, height = 0.2, thickness = 0.07;

  ExtrusionOf()
      : section_(distorted_box<Plane>({width, height}, {columns, rows})),
        solid_(extruded(section_.mesh)) {}

  static mesh::Mesh3D extruded(const mesh::Mesh2D& section) {
    return box_mesh({columns, 1, rows}, is_simplex<Solid>, [&](const Vector3& s) {
      const int i = int(std::lround(s[0] * columns));
      const int k = int(std::lround(s[2] * rows));
      const double* x = section.point(k * (columns + 1) + i);
      return Vector3{x[0], thickness * s[1], x[1]};
    });
  }
  int node_of_section(int n) const {
    return n / (2 * (columns + 1)) * (columns + 1) + n % (columns + 1);
  }

  void expect_the_same_displacement(double tolerance) const {
    double size = 0.0;
    for (double u : section_.displacement()) size = std::max(size, std::abs(u));
    for (int n = 0; n < solid_.mesh.nodes(); ++n) {
      const std::size_t m = std::size_t(node_of_section(n));
      EXPECT_NEAR(solid_.displacement(n, 0), section_.displacement()[2 * m], tolerance * size);
      EXPECT_NEAR(solid_.displacement(n, 2), section_.displacement()[2 * m + 1], tolerance * size);
      EXPECT_NEAR(solid_.displacement(n, 1), 0.0, tolerance * size);
    }
  }

  FixedBody<Plane> section_;
  FixedBody<Solid> solid_;
};

using Pairs = ::testing::Types<Extrusion<fem::Q1Quadrilateral, fem::Q1Hexahedron>,
                               Extrusion<fem::BendingQuadrilateral, fem::BendingHexahedron>>;
TYPED_TEST_SUITE(ExtrusionOf, Pairs);

/// A section that creeps under a load at its side for some steps, one side held: the 2D figures.
TYPED_TEST(ExtrusionOf, CreepsAsTheSectionDoes) {
  auto& section = this->section_;
  auto& solid = this->solid_;
  section.set_material(1e9, 0.35, 1e-35, 6.0);
  solid.set_material(1e9, 0.35, 1e-35, 6.0);
  for (int n : mesh::patch_nodes(face(solid.mesh, 0, -1.0))) solid.fix(n, {0.0, 0.0, 0.0});
  for (int n = 0; n < solid.mesh.nodes(); ++n) solid.fix(n, 1, 0.0);
  for (int n = 0; n < section.mesh.nodes(); n += this->columns + 1) {
    section.fix(n, 0, 0.0), section.fix(n, 1, 0.0);
  }
  solid.add_traction(face(solid.mesh, 0, 1.0), [](double, double, double z) {
    return Vector3{2e6 * z, 0.0, 1e6};
  });
  section.add_traction(mesh::PatchKind::side, [](double, double y) {
    return Vector2{2e6 * y, 1e6};
  });
  for (int e = 0; e < section.mesh.elements(); ++e) {
    section.problem.thermal[std::size_t(e)] = solid.problem.thermal[std::size_t(e)] = 1e-4 * e;
  }
  for (int step = 0; step < 3; ++step) {
    ASSERT_TRUE(section.step(tight(1e-11)).converged);
    ASSERT_TRUE(solid.step(tight(1e-11)).converged);
    this->expect_the_same_displacement(1e-10);
  }
}

/// A section on a floor of any shape, its top shrunk: the 2D contact.
TYPED_TEST(ExtrusionOf, StandsOnAFloorAsTheSectionDoes) {
  auto& section = this->section_;
  auto& solid = this->solid_;
  section.set_material(1e9, 0.35, 0.0, 6.0);
  solid.set_material(1e9, 0.35, 0.0, 6.0);
  section.set_contact();
  solid.set_contact();
  const auto floor = [](double x) { return -1e-3 * x * x; };
  for (int unknown : section.problem.contact) {
    section.problem.initial_gap.push_back(floor(section.mesh.point(unknown / 2)[0]));
  }
  for (int unknown : solid.problem.contact) {
    solid.problem.initial_gap.push_back(floor(solid.mesh.point(unknown / 3)[0]));
  }
  const std::vector<double> weight(section.forms.elements(), 2.5e6);
  section.problem.weight = section.forms.subtract_weight(weight, section.problem.external_force);
  solid.problem.weight = solid.forms.subtract_weight(weight, solid.problem.external_force);
  EXPECT_NEAR(solid.problem.weight, this->thickness * section.problem.weight,
              1e-12 * solid.problem.weight);

  for (int e = 0; e < section.mesh.elements(); ++e) {
    section.problem.thermal[std::size_t(e)] = solid.problem.thermal[std::size_t(e)] =
        -5e-3 * (e / this->columns);
  }
  for (int n = 0; n < solid.mesh.nodes(); ++n) solid.fix(n, 1, 0.0);
  hold_low_end(solid, 0);
  hold_low_end(section, 0);
  ASSERT_TRUE(section.step(tight(1e-11)).converged);
  ASSERT_TRUE(solid.step(tight(1e-11)).converged);

  this->expect_the_same_displacement(1e-9);
  EXPECT_NE(std::count(solid.unknowns().contact.begin(), solid.unknowns().contact.end(), 0), 0);
}

/// Tests T3 and T4 of the paper: a block drawn along x and pressed along the height by tractions
/// that grow evenly, its strain uniform and known; held below in T3, standing on a floor in T4.
template <class Pair>
class UniformStressOf : public ExtrusionOf<Pair> {
protected:
  static constexpr double young = 1e9, poisson = 0.35, kappa = 1.953125e-39, exponent = 6.0;
  static constexpr double traction_rate = 1e8;  // [Pa/s]
  static constexpr double dt = 0.02;            // [s]
  static constexpr int steps = 25;

  /// The exact stretch at the end of a step, with backward Euler's sum in place of the integral of
  /// t^5: with it each step has the exact stress.
  static double stretch(int step) {
    double sum = 0.0;
    for (int i = 1; i <= step; ++i) sum += dt * std::pow(i * dt, 5);
    return traction_rate * (1.0 + poisson) / young * step * dt +
           2.0 / 3.0 * 1e40 * kappa * 6.0 * sum;
  }

  void run(bool contact) {
    this->section_.set_material(young, poisson, kappa, exponent);
    this->solid_.set_material(young, poisson, kappa, exponent);
    if (contact) {
      this->section_.set_contact();
      this->section_.set_closed_contact();
      this->solid_.set_contact();
    }
    for (int i = 1; i <= steps; ++i) step(i, contact);
  }

  void step(int number, bool contact) {
    const double p = traction_rate * number * dt, h = stretch(number);
    load(p);
    for (int n = 0; n < this->section_.mesh.nodes(); ++n) {
      const double* x = this->section_.mesh.point(n);
      if (x[0] == 0.0 || (!contact && x[1] == 0.0)) this->section_.fix(n, 0, h * x[0]);
      if ((x[0] == 0.0 && !(contact && x[1] == 0.0)) || (!contact && x[1] == 0.0))
        this->section_.fix(n, 1, -h * x[1]);
    }
    for (int n = 0; n < this->solid_.mesh.nodes(); ++n) {
      const Vector3 x = this->solid_.place(n);
      this->solid_.fix(n, 1, 0.0);
      if (x[0] == 0.0 || (!contact && x[2] == 0.0)) this->solid_.fix(n, 0, h * x[0]);
      if ((x[0] == 0.0 && !(contact && x[2] == 0.0)) || (!contact && x[2] == 0.0))
        this->solid_.fix(n, 2, -h * x[2]);
    }
    ASSERT_TRUE(this->section_.step(tight(1e-11), dt).converged) << number;
    ASSERT_TRUE(this->solid_.step(tight(1e-11), dt).converged) << number;
  }

  void load(double p) {
    this->section_.clear_forces();
    this->section_.add_traction(mesh::PatchKind::side, [p](double, double) {
      return Vector2{p, 0.0};
    });
    this->section_.add_traction(mesh::PatchKind::top, [p](double, double) {
      return Vector2{0.0, -p};
    });
    this->section_.problem.weight = p * this->width;
    auto& solid = this->solid_;
    solid.clear_forces();
    solid.add_traction(face(solid.mesh, 0, 1.0), [p](double, double, double) {
      return Vector3{p, 0.0, 0.0};
    });
    solid.add_traction(face(solid.mesh, 2, 1.0), [p](double, double, double) {
      return Vector3{0.0, 0.0, -p};
    });
    this->solid_.problem.weight = p * this->width * this->thickness;
  }

  void expect_the_exact_displacement() const {
    const double h = stretch(steps);
    for (int n = 0; n < this->solid_.mesh.nodes(); ++n) {
      const Vector3 x = this->solid_.place(n);
      EXPECT_NEAR(this->solid_.displacement(n, 0), h * x[0], 1e-8 * h * this->width);
      EXPECT_NEAR(this->solid_.displacement(n, 2), -h * x[2], 1e-8 * h * this->width);
    }
  }
};

using UniformPairs = ::testing::Types<Extrusion<fem::P1Triangle, fem::P1Tetrahedron>,
                                      Extrusion<fem::Q1Quadrilateral, fem::Q1Hexahedron>,
                                      Extrusion<fem::BendingQuadrilateral, fem::BendingHexahedron>>;
TYPED_TEST_SUITE(UniformStressOf, UniformPairs);

TYPED_TEST(UniformStressOf, GivesTheFiguresOfT3) {
  this->run(false);
  if (TypeParam::Section::nodes == 4) this->expect_the_same_displacement(1e-8);
  this->expect_the_exact_displacement();
}

TYPED_TEST(UniformStressOf, GivesTheFiguresOfT4) {
  this->run(true);
  if (TypeParam::Section::nodes == 4) this->expect_the_same_displacement(1e-8);
  this->expect_the_exact_displacement();
}

}  // namespace
}  // namespace dccast::mechanics
