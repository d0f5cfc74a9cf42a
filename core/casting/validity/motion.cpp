#include "core/casting/validity/motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace dccast::casting {

double rotation(const mesh::Mesh2D& mesh, int element, std::span<const double> displacement) {
  // Integrals of grad u by Gauss' theorem: u is linear along each edge.
  double area = 0.0, xx = 0.0, xy = 0.0, yx = 0.0, yy = 0.0;
  const int* node = mesh.nodes_of(element);
  for (int i = 0; i < mesh.nodes_per_element; ++i) {
    const int a = node[i], b = node[(i + 1) % mesh.nodes_per_element];
    const double* from = mesh.point(a);
    const double* to = mesh.point(b);
    const double dx = to[0] - from[0], dy = to[1] - from[1];
    const double u = 0.5 * (displacement[2 * std::size_t(a)] + displacement[2 * std::size_t(b)]);
    const double v =
        0.5 * (displacement[2 * std::size_t(a) + 1] + displacement[2 * std::size_t(b) + 1]);
    area += 0.5 * (from[0] * to[1] - to[0] * from[1]);
    xx += u * dy, xy -= u * dx;
    yx += v * dy, yy -= v * dx;
  }
  return std::atan2(yx - xy, 2.0 * area + xx + yy);
}

std::array<double, 2> centroid(const mesh::Mesh2D& mesh, int element) {
  std::array<double, 2> sum{};
  for (int i = 0; i < mesh.nodes_per_element; ++i) {
    const double* at = mesh.point(mesh.nodes_of(element)[i]);
    sum[0] += at[0] / mesh.nodes_per_element;
    sum[1] += at[1] / mesh.nodes_per_element;
  }
  return sum;
}

Extreme largest_rotation(const mesh::Mesh2D& mesh, std::span<const char> solid,
                         std::span<const double> displacement, int growing,
                         std::vector<double>& when_liquid) {
  when_liquid.resize(std::size_t(mesh.elements()), 0.0);
  double largest = 0.0;
  int where = -1;
  for (int e = 0; e < mesh.elements(); ++e) {
    const double angle = rotation(mesh, e, displacement);
    double& reference = when_liquid[std::size_t(e)];
    if (solid[std::size_t(e)] == 0 || e >= growing) reference = angle;
    const double apart = std::abs(angle - reference);
    const double turned = std::min(apart, 2.0 * std::numbers::pi - apart);  // the shorter way
    if (turned <= largest) continue;
    largest = turned;
    where = e;
  }
  return {largest, where < 0 ? std::array<double, 2>{} : centroid(mesh, where)};
}

Extreme largest_slip(const mesh::Mesh2D& mesh, std::span<const char> solid,
                     std::span<const double> displacement, std::span<const double> temperature,
                     const material::MechanicalProperties& properties, double solid_below) {
  Extreme slip;
  double contraction = 0.0;  // of the solid from the symmetry plane to here [m]
  const auto judge = [&](int n) {
    const double u = displacement[2 * std::size_t(n)];
    const double beyond = std::max(u, -contraction - u);
    if (beyond > slip.value) slip = {beyond, {mesh.point(n)[0], mesh.point(n)[1]}};
  };
  for (const auto& edge : mesh.facets(mesh::PatchKind::bottom)) {
    if (solid[std::size_t(edge.element)] == 0) continue;
    const int a = edge.node[0], b = edge.node[1];
    const double mean = 0.5 * (temperature[std::size_t(a)] + temperature[std::size_t(b)]);
    const double strain =
        properties.thermal_stretch(solid_below) - properties.thermal_stretch(mean);
    judge(a);
    contraction += std::max(0.0, strain) * std::abs(mesh.point(b)[0] - mesh.point(a)[0]);
    judge(b);
  }
  return slip;
}

}  // namespace dccast::casting
