#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/mesh/mesh.hpp"

namespace dccast::mesh {

/// Inward unit normals of the bottom's nodes [1]: means of the facets around each, weighted by
/// area. Exactly vertical on a flat block.
/// @param nodes  of the bottom
template <int Dim>
std::vector<std::array<double, Dim>> inward_normals(const Mesh<Dim>& mesh,
                                                    const std::vector<int>& nodes) {
  std::vector<std::array<double, Dim>> sum(std::size_t(mesh.nodes()));
  for_each_facet(mesh, PatchKind::bottom, [&](const Facet<Dim>& facet, const auto&) {
    // Facets turn counterclockwise seen from outside, so that this vector points outward. Its
    // length is the area: of a quadrilateral, half the product of the diagonals.
    std::array<double, Dim> outward{};
    const auto corner = [&](int k) { return mesh.point(facet.node[std::size_t(k)]); };
    if constexpr (Dim == 2) {
      const double *a = corner(0), *b = corner(1);
      outward = {b[1] - a[1], -(b[0] - a[0])};
    } else {
      const bool triangle = facet.nodes == 3;
      const double *a = corner(0), *b = corner(1), *c = corner(2);
      const double *d = triangle ? a : b, *e = triangle ? b : corner(3);
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
        outward[i] = 0.5 * ((c[j] - a[j]) * (e[k] - d[k]) - (c[k] - a[k]) * (e[j] - d[j]));
        if (triangle) outward[i] = -outward[i];
      }
    }

    for (int k = 0; k < facet.nodes; ++k)
      for (std::size_t i = 0; i < Dim; ++i)
        sum[std::size_t(facet.node[std::size_t(k)])][i] -= outward[i];
  });

  std::vector<std::array<double, Dim>> normals;
  for (const int n : nodes) {
    std::array<double, Dim> normal = sum[std::size_t(n)];
    double squares = 0.0;
    for (const double part : normal) squares += part * part;
    for (double& part : normal) part /= std::sqrt(squares);
    normals.push_back(normal);
  }
  return normals;
}

}  // namespace dccast::mesh
