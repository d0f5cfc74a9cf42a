#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/mechanics_solid/solid_body.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

enum class Moment { along, both, twisting };

/// A plate of thickness 1, bent by moments on its edges; a quarter of it where it is symmetric.
struct Plate {
  Moment moment;
  double poisson, cell;  ///< cell length over thickness
  int layers;
  double skew = 0.0;   ///< of the cells in the plane of the plate [cell lengths across the plate]
  double slant = 0.0;  ///< of the cells' ends [thicknesses]
};
constexpr int columns = 6, strips = 4;
constexpr double young = 1e9, slope = 1e6;  // of the edge traction across the plate [Pa/m]

BoxMesh shape_of(const Plate& plate, bool tetrahedra) {
  const double length = plate.cell * columns, width = plate.cell * strips;
  return box_mesh({columns, strips, plate.layers}, tetrahedra, [&](const Vector3& s) {
    const bool inside = s[0] > 0.0 && s[0] < 1.0;
    const double shift = plate.skew * plate.cell * (s[1] - 0.5) + plate.slant * (s[2] - 0.5);
    return Vector3{s[0] * length + (inside ? shift : 0.0), s[1] * width, s[2]};
  });
}

/// Displacement of thin plates under a twisting moment.
Vector3 twisted(double poisson, const Vector3& x) {
  const double a = slope * (1.0 + poisson) / young, z = x[2] - 0.5;
  return {a * x[1] * z, a * x[0] * z, -a * x[0] * x[1]};
}

template <class Element>
void load(SolidBody<Element>& body, const Plate& plate) {
  const auto pull = [](std::size_t direction, double sign) {
    return [=](const Vector3& x) {
      Vector3 t{};
      t[direction] = sign * slope * (x[2] - 0.5);
      return t;
    };
  };
  if (plate.moment == Moment::twisting) {
    body.add_traction(Face::x_low, pull(1, -1.0));
    body.add_traction(Face::x_high, pull(1, 1.0));
    body.add_traction(Face::y_low, pull(0, -1.0));
    body.add_traction(Face::y_high, pull(0, 1.0));
    return;
  }
  body.add_traction(Face::x_high, pull(0, 1.0));
  if (plate.moment == Moment::both) body.add_traction(Face::y_high, pull(1, 1.0));
}

template <class Element>
void support(SolidBody<Element>& body, const Plate& plate) {
  const auto& box = body.box;
  if (plate.moment == Moment::twisting) {
    const int origin = box.node(0, 0, 0), x_end = box.node(columns, 0, 0);
    body.fix(origin, twisted(plate.poisson, body.place(origin)));
    for (int d : {1, 2}) {
      body.fix(x_end, d, twisted(plate.poisson, body.place(x_end))[std::size_t(d)]);
    }
    body.fix(box.node(0, strips, 0), 2, 0.0);
    return;
  }
  for (int n : box.nodes_on(Face::x_low)) body.fix(n, 0, 0.0);
  for (int n : box.nodes_on(Face::y_low)) body.fix(n, 1, 0.0);
  body.fix(box.node(0, 0, 0), 2, 0.0);
}

/// Deflection over that of thin plates.
template <class Element>
double deflection(const Plate& plate) {
  SolidBody<Element> body(shape_of(plate, of_tetrahedra<Element>));
  body.set_material(young, plate.poisson);
  load(body, plate);
  support(body, plate);
  EXPECT_TRUE(body.step(in_balance(1e-8)).converged);
  if (plate.moment == Moment::twisting) {
    const int corner = body.box.node(columns, strips, 0);
    return body.displacement(corner, 2) / twisted(plate.poisson, body.place(corner))[2];
  }
  const double length = plate.cell * columns;
  const double softness = plate.moment == Moment::both ? 1.0 - plate.poisson : 1.0;
  const double exact = -slope * length * length * softness / (2.0 * young);
  return body.displacement(body.box.node(columns, 0, 0), 2) / exact;
}

template <class Element>
double deflection_along(double poisson, double cell, int layers) {
  return deflection<Element>({Moment::along, poisson, cell, layers});
}

/// Nearly incompressible deformation is in the space of the element: one layer of cells ten times
/// longer than thick has the deflection of thin plates, bent in one direction and in both.
TEST(BendingHexahedron, OneLayerOfLongCellsBendsAtConstantVolume) {
  for (const double cell : {1.0, 2.75, 5.5, 10.0}) {
    for (const Moment moment : {Moment::along, Moment::both, Moment::twisting}) {
      EXPECT_NEAR(deflection<fem::BendingHexahedron>({moment, 0.4999, cell, 1}), 1.0, 1e-3)
          << cell << ", moment " << int(moment);
    }
  }
}

/// At other ratios the element is too stiff because of the volumetric stiffness within a layer,
/// independently of the length; the error decreases with the square of the number of layers.
TEST(BendingHexahedron, LayersBringTheRestWhateverTheLength) {
  for (const double cell : {1.0, 2.75, 5.5, 10.0}) {
    EXPECT_NEAR(deflection_along<fem::BendingHexahedron>(0.45, cell, 1), 0.967, 1e-3) << cell;
    EXPECT_NEAR(deflection_along<fem::BendingHexahedron>(0.3, cell, 1), 0.867, 1e-3) << cell;
    EXPECT_NEAR(deflection_along<fem::BendingHexahedron>(0.3, cell, 4), 0.987, 1e-3) << cell;
    EXPECT_NEAR(deflection<fem::BendingHexahedron>({Moment::both, 0.3, cell, 4}), 0.963, 1e-3)
        << cell;
    // Exact but for round-off. A cell is cell^4 times as stiff across as in twist; what double
    // precision leaves of the forces, and no further iteration lowers, is 2.4e-14 of the load at 1,
    // 2.3e-11 at 10 and 6e-10 at 32: cell^3. The deflection follows: 2e-9 at 10, 1.2e-8 at 16.
    const double round_off = std::max(1e-9, 5e-12 * cell * cell * cell);
    EXPECT_NEAR(deflection<fem::BendingHexahedron>({Moment::twisting, 0.3, cell, 1}), 1.0,
                round_off)
        << cell;
  }
}

TEST(Q1Hexahedron, LocksInBending) {
  EXPECT_LE(deflection_along<fem::Q1Hexahedron>(0.3, 5.5, 4), 0.1);
  EXPECT_LE(deflection_along<fem::Q1Hexahedron>(0.4999, 5.5, 1), 0.1);
}
TEST(P1Tetrahedron, LocksInBending) {
  EXPECT_LE(deflection_along<fem::P1Tetrahedron>(0.3, 5.5, 4), 0.1);
}

/// Cells skewed in the plane of the plate by a cell length, and slanted by twice the thickness: the
/// modes follow the planes of the cell.
TEST(BendingHexahedron, SkewedCellsBendToo) {
  for (const Moment moment : {Moment::along, Moment::both, Moment::twisting}) {
    const double straight = deflection<fem::BendingHexahedron>({moment, 0.3, 2.0, 2});
    EXPECT_NEAR(deflection<fem::BendingHexahedron>({moment, 0.3, 2.0, 2, 1.0, 0.0}), straight,
                0.02);
    EXPECT_NEAR(deflection<fem::BendingHexahedron>({moment, 0.3, 2.0, 2, 0.0, 2.0}), straight,
                0.07);
  }
  EXPECT_LE(deflection<fem::Q1Hexahedron>({Moment::along, 0.3, 2.0, 2, 0.0, 2.0}), 0.15);
}

/// A cube squeezed by a tenth of its height while it creeps, with an hourglass of strain in it at
/// the start: the hourglass of the displacement stays the size it was.
TEST(BendingHexahedron, AnHourglassDoesNotGrowUnderCompression) {
  constexpr int cells = 4, steps = 20;
  SolidBody<fem::BendingHexahedron> body(
      box_mesh({cells, cells, cells}, false, [](const Vector3& s) { return s; }));
  body.set_material(4e10, 0.45, 1e-40);

  // An hourglass of strain: its sign changes from cell to cell, its shape is the first modes.
  const auto pattern = [](int e) {
    return (e / cells / cells + e / cells % cells + e % cells) % 2 == 0 ? 1.0 : -1.0;
  };
  for (int e = 0; e < body.box.mesh.elements(); ++e) {
    const auto& cell = body.forms.geometry().cell(e);
    for (std::size_t q = 0; q < 8; ++q) {
      for (std::size_t m = 0; m < fem::SolidBending::modes; ++m) {
        body.problem.inelastic[8 * std::size_t(e) + q].add(
            1e-4 * pattern(e) * cell.point[q].lever[fem::SolidBending::lever_of(m)],
            cell.bending.mode[m].strain);
      }
    }
  }

  // Size of the hourglass in the displacement [m].
  const auto hourglass = [&] {
    double sum = 0.0;
    for (int e = 0; e < body.box.mesh.elements(); ++e) {
      for (const auto& warp : body.forms.geometry().cell(e).bending.warp) {
        for (int d = 0; d < 3; ++d) {
          double q = 0.0;
          for (int i = 0; i < 8; ++i) {
            q += warp[std::size_t(i)] * body.displacement(body.box.mesh.nodes_of(e)[i], d);
          }
          sum += q * q;
        }
      }
    }
    return std::sqrt(sum);
  };

  // Squeeze the cube between its bottom and its top, free to spread sideways.
  for (int n : body.box.nodes_on(Face::x_low)) body.fix(n, 0, 0.0);
  for (int n : body.box.nodes_on(Face::y_low)) body.fix(n, 1, 0.0);
  for (int n : body.box.nodes_on(Face::z_low)) body.fix(n, 2, 0.0);
  double first = 0.0;
  for (int step = 1; step <= steps; ++step) {
    for (int n : body.box.nodes_on(Face::z_high)) body.fix(n, 2, -0.1 * step / steps);
    ASSERT_TRUE(body.step(in_balance(1e-9)).converged) << step;
    if (step == 1) first = hourglass();
    EXPECT_LE(hourglass(), 1.1 * first) << step;
  }

  EXPECT_GT(first, 1e-7) << "there was one";
}

}  // namespace
}  // namespace dccast::mechanics
