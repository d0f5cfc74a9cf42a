#include "tests/verification/mechanics/fixed_body.hpp"

#include <ctime>

namespace dccast::verification {

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

mesh::Mesh2D uniform_rectangle(double width, double height, int columns, int rows,
                               mesh::ElementKind kind) {
  mesh::SectionSpec spec;
  spec.half_width = width;
  spec.initial_depth = height;
  spec.element = kind;
  spec.columns = columns;
  spec.rows = rows;
  spec.side_cell = width / columns;
  spec.bottom_cell = height / rows;
  return mesh::SlabMesh2D(spec).mesh();
}

namespace {

using Triangle = std::array<Vector2, 3>;

Vector2 middle(const Vector2& a, const Vector2& b) {
  return {0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])};
}

/// The three-point rule, exact for quadratics, on each of 4^levels equal sub-triangles.
void subdivide(const Triangle& t, int levels, double area,
               std::vector<std::pair<Vector2, double>>& out) {
  if (levels == 0) {
    constexpr double near = 2.0 / 3.0, far = 1.0 / 6.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector2 &a = t[k], &b = t[(k + 1) % 3], &c = t[(k + 2) % 3];
      out.push_back(
          {{near * a[0] + far * (b[0] + c[0]), near * a[1] + far * (b[1] + c[1])}, area / 3.0});
    }
    return;
  }
  const Vector2 ab = middle(t[0], t[1]), bc = middle(t[1], t[2]), ca = middle(t[2], t[0]);
  for (const Triangle& part : {Triangle{t[0], ab, ca}, Triangle{ab, t[1], bc},
                               Triangle{ca, bc, t[2]}, Triangle{bc, ca, ab}}) {
    subdivide(part, levels - 1, 0.25 * area, out);
  }
}

Vector2 position(const mesh::Mesh2D& mesh, int node) {
  return {mesh.point(node)[0], mesh.point(node)[1]};
}

std::vector<IntegrationPoint> on_triangle(const mesh::Mesh2D& mesh, const int* node) {
  const Triangle corners{position(mesh, node[0]), position(mesh, node[1]), position(mesh, node[2])};
  const auto [a, b, c] = corners;
  const double twice = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
  std::vector<std::pair<Vector2, double>> points;
  subdivide(corners, 2, 0.5 * twice, points);
  std::vector<IntegrationPoint> result;
  for (const auto& [p, weight] : points) {
    const double s = ((p[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (p[1] - a[1])) / twice;
    const double t = ((b[0] - a[0]) * (p[1] - a[1]) - (p[0] - a[0]) * (b[1] - a[1])) / twice;
    result.push_back({p[0], p[1], weight, {1.0 - s - t, s, t, 0.0}});
  }
  return result;
}

std::vector<IntegrationPoint> on_quadrilateral(const mesh::Mesh2D& mesh, const int* node) {
  constexpr int parts = 6;  // by the midpoint of each part
  std::vector<IntegrationPoint> result;
  for (int i = 0; i < parts * parts; ++i) {
    const Vector2 p{(2.0 * (i % parts) + 1.0) / parts - 1.0,
                    (2.0 * (i / parts) + 1.0) / parts - 1.0};
    const auto shape = fem::Q1Quadrilateral::shape(p);
    const auto gradient = fem::Q1Quadrilateral::shape_gradient(p);
    double x = 0, y = 0, xa = 0, xb = 0, ya = 0, yb = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const Vector2 at = position(mesh, node[k]);
      x += shape[k] * at[0], y += shape[k] * at[1];
      xa += gradient[k][0] * at[0], xb += gradient[k][1] * at[0];
      ya += gradient[k][0] * at[1], yb += gradient[k][1] * at[1];
    }
    result.push_back({x, y, 4.0 / (parts * parts) * (xa * yb - xb * ya), shape});
  }
  return result;
}

}  // namespace

std::vector<IntegrationPoint> integration_points(const mesh::Mesh2D& mesh, int element) {
  const int* node = mesh.nodes_of(element);
  return mesh.nodes_per_element == 3 ? on_triangle(mesh, node) : on_quadrilateral(mesh, node);
}

}  // namespace dccast::verification
