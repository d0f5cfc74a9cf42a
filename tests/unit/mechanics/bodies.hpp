#pragma once

#include <cmath>

#include "tests/support/usual_options.hpp"
#include "tests/verification/mechanics/fixed_body.hpp"

/// Bodies and options the tests of mechanics share.
namespace dccast::mechanics::testing {

using verification::FixedBody;
using verification::PlaneStress;
using verification::Vector2;

template <class Element>
constexpr mesh::ElementKind kind_of =
    Element::nodes == 3 ? mesh::ElementKind::p1 : mesh::ElementKind::q1;

/// A rectangle whose inner nodes are moved by up to a quarter of a cell.
template <class Element>
mesh::Mesh2D distorted_rectangle(double width, double height, int columns, int rows) {
  mesh::Mesh2D mesh =
      verification::uniform_rectangle(width, height, columns, rows, kind_of<Element>);
  for (int n = 0; n < mesh.nodes(); ++n) {
    double* x = &mesh.node[2 * std::size_t(n)];
    if (x[0] == 0.0 || x[0] == width || x[1] == 0.0 || x[1] == height) continue;
    x[0] += 0.25 * width / columns * std::sin(3.0 * n + 1.0);
    x[1] += 0.25 * height / rows * std::cos(5.0 * n);
  }
  return mesh;
}

inline bool on_boundary(const mesh::Mesh2D& mesh, int node) {
  for (const auto& patch : mesh.patches) {
    for (const auto& facet : patch.facets) {
      if (facet.node[0] == node || facet.node[1] == node) return true;
    }
  }
  return false;
}

/// Holds every node of the boundary at a displacement.
template <class Element, class Field>
void hold_boundary(FixedBody<Element>& body, Field&& displacement) {
  for (int n = 0; n < body.mesh.nodes(); ++n) {
    if (!on_boundary(body.mesh, n)) continue;
    const Vector2 u = displacement(body.mesh.point(n)[0], body.mesh.point(n)[1]);
    body.fix(n, 0, u[0]);
    body.fix(n, 1, u[1]);
  }
}

inline Options tight(double tolerance = 1e-14) {
  return dccast::testing::usual_options(tolerance);
}

inline PlaneStress difference(PlaneStress a, const PlaneStress& b) {
  return a.add(-1.0, b);
}

}  // namespace dccast::mechanics::testing
