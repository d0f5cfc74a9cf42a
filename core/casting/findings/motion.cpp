#include "core/casting/findings/motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "core/base/tensors.hpp"
#include "core/fem/element.hpp"

namespace dccast::casting {

namespace {

/// I + grad u at the centre of a tetrahedron or hexahedron, row by row: Jacobian of the reference
/// cell after the motion, times the inverse of the one before.
template <std::size_t Nodes>
Matrix3 deformation_gradient(const mesh::Mesh3D& mesh, int element,
                             std::span<const double> displacement,
                             const std::array<std::array<double, 3>, Nodes>& gradient) {
  Matrix3 before{}, after{};
  const int* node = mesh.nodes_of(element);

  // Sums of x_i grad N_i over the nodes, before and after the motion.
  for (std::size_t i = 0; i < gradient.size(); ++i) {
    const double* x = mesh.point(node[i]);
    const double* u = &displacement[3 * std::size_t(node[i])];
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t k = 0; k < 3; ++k) {
        before[r][k] += x[r] * gradient[i][k];
        after[r][k] += (x[r] + u[r]) * gradient[i][k];
      }
    }
  }

  return product(after, inverse(before));
}

/// atan2(y, x). Small angles, by far the most frequent, are computed by the series, which is exact
/// to rounding error there and takes a fraction of the time.
double fast_atan2(double y, double x) {
  constexpr double small = 0.02;  // its eleventh power is negligible relative to it
  const double t = y / x;
  if (!(x > 0.0 && std::abs(t) < small)) return std::atan2(y, x);
  const double square = t * t;
  return t * (1.0 - square * (1.0 / 3.0 - square * (0.2 - square * (1.0 / 7.0 - square / 9.0))));
}

/// Angle of the rotation from one turn to another [rad], 0 to pi.
double angle_between(const Turn<2>& from, const Turn<2>& to) {
  const double difference = std::abs(to[0] - from[0]);
  return std::min(difference, 2.0 * std::numbers::pi - difference);
}

/// Angle of the rotation from one turn to another [rad], 0 to pi.
double angle_between(const Turn<3>& from, const Turn<3>& to) {
  // Real and imaginary parts of the product of one with the conjugate of the other.
  const double real = from[0] * to[0] + from[1] * to[1] + from[2] * to[2] + from[3] * to[3];
  const double i = from[0] * to[1] - from[1] * to[0] - from[2] * to[3] + from[3] * to[2];
  const double j = from[0] * to[2] - from[2] * to[0] - from[3] * to[1] + from[1] * to[3];
  const double k = from[0] * to[3] - from[3] * to[0] - from[1] * to[2] + from[2] * to[1];
  return 2.0 * std::atan2(std::hypot(i, j, k), std::abs(real));
}

/// Contraction of a facet of the bottom from solid_below to its mean temperature [1], at least
/// zero.
template <int Dim>
double facet_contraction(const mesh::Facet<Dim>& facet, std::span<const double> temperature,
                         const material::MechanicalProperties& properties, double solid_below) {
  double sum = 0.0;
  for (int i = 0; i < facet.nodes; ++i) sum += temperature[std::size_t(facet.node[std::size_t(i)])];
  const double mean = sum / facet.nodes;
  return std::max(0.0, properties.thermal_stretch(solid_below) - properties.thermal_stretch(mean));
}

/// Updates the largest slip with a node: its displacement `u` along one axis against the
/// contraction, both [m].
template <int Dim>
void update_slip(const mesh::Mesh<Dim>& mesh, int n, double u, double contraction,
                 PlacedFigure& slip) {
  const double beyond = std::max(u, -contraction - u);
  if (beyond > slip.value) slip = {beyond, {mesh.point(n), mesh.point(n) + Dim}};
}

}  // namespace

Turn<2> element_turn(const mesh::Mesh2D& mesh, int element, std::span<const double> displacement) {
  // By Gauss' theorem the integral of grad u over a quadrilateral depends on its diagonals only,
  // because u is linear along each edge. For a triangle the two edges at its third node take their
  // place.
  const int* node = mesh.nodes_of(element);
  const int corners = mesh.nodes_per_element;
  const std::array<int, 2> from{node[0], node[1]}, to{node[2], node[corners - 1]};

  std::array<double, 2> x{}, y{}, u{}, v{};
  for (std::size_t k = 0; k < 2; ++k) {
    const double* begin = mesh.point(from[k]);
    const double* end = mesh.point(to[k]);
    const double* moved_begin = &displacement[2 * std::size_t(from[k])];
    const double* moved_end = &displacement[2 * std::size_t(to[k])];
    x[k] = end[0] - begin[0];
    y[k] = end[1] - begin[1];
    u[k] = moved_end[0] - moved_begin[0];
    v[k] = moved_end[1] - moved_begin[1];
  }

  const double twice_area = x[0] * y[1] - x[1] * y[0];
  const double curl = v[0] * y[1] - v[1] * y[0] + u[0] * x[1] - u[1] * x[0];
  const double divergence = u[0] * y[1] - u[1] * y[0] - v[0] * x[1] + v[1] * x[0];
  return {fast_atan2(curl, 2.0 * twice_area + divergence)};
}

Turn<3> element_turn(const mesh::Mesh3D& mesh, int element, std::span<const double> displacement) {
  return fem::with_linear_element<3>(mesh.nodes_per_element, [&]<class Element>() {
    // At the centre of a brick; of a tetrahedron the gradient is the same everywhere.
    static const auto gradient = Element::shape_gradient({0.0, 0.0, 0.0});
    return quaternion_of(
        polar_rotation(deformation_gradient(mesh, element, displacement, gradient)));
  });
}

template <int Dim>
std::vector<double> centroid(const mesh::Mesh<Dim>& mesh, int element) {
  std::vector<double> sum(Dim, 0.0);
  for (int i = 0; i < mesh.nodes_per_element; ++i) {
    const double* x = mesh.point(mesh.nodes_of(element)[i]);
    for (std::size_t d = 0; d < Dim; ++d) sum[d] += x[d] / mesh.nodes_per_element;
  }
  return sum;
}

template <int Dim>
PlacedFigure largest_rotation(const mesh::Mesh<Dim>& mesh, std::span<const char> solid,
                              std::span<const double> displacement, int growing,
                              std::vector<double>& when_liquid) {
  constexpr std::size_t numbers = std::tuple_size_v<Turn<Dim>>;
  constexpr Turn<Dim> unmoved{Dim == 2 ? 0.0 : 1.0};
  while (when_liquid.size() < std::size_t(mesh.elements()) * numbers)
    when_liquid.insert(when_liquid.end(), unmoved.begin(), unmoved.end());

  double largest = 0.0;
  int turned_element = -1;
  for (int e = 0; e < mesh.elements(); ++e) {
    const Turn<Dim> turn = element_turn(mesh, e, displacement);
    const auto stored = when_liquid.begin() + static_cast<std::ptrdiff_t>(std::size_t(e) * numbers);
    // Liquid turns freely: a rotation counts from where its element was last liquid.
    if (solid[std::size_t(e)] == 0 || e >= growing) std::ranges::copy(turn, stored);

    Turn<Dim> reference;
    std::copy_n(stored, numbers, reference.begin());
    const double turned = angle_between(reference, turn);
    if (turned <= largest) continue;
    largest = turned;
    turned_element = e;
  }
  return {largest,
          turned_element < 0 ? std::vector<double>(Dim, 0.0) : centroid(mesh, turned_element)};
}

template <int Dim>
void merge_turns(const mesh::MergedRows& merged, std::vector<double>& when_liquid) {
  if (when_liquid.empty()) return;
  const std::size_t stride = merged.elements_per_row * std::tuple_size_v<Turn<Dim>>;

  std::vector<double> after;
  for (const auto& row : merged.made_of()) {
    const auto from = when_liquid.begin() + static_cast<std::ptrdiff_t>(row[0] * stride);
    after.insert(after.end(), from, from + static_cast<std::ptrdiff_t>(stride));
  }
  when_liquid = std::move(after);
}

PlacedFigure largest_slip(const mesh::Mesh2D& mesh, std::span<const char> solid,
                          std::span<const double> displacement, std::span<const double> temperature,
                          const material::MechanicalProperties& properties, double solid_below) {
  PlacedFigure slip;
  double contraction = 0.0;  // of the solid between the symmetry plane and the node [m]
  for (const auto& edge : mesh.facets(mesh::PatchKind::bottom)) {
    if (solid[std::size_t(edge.element)] == 0) continue;

    const int a = edge.node[0], b = edge.node[1];
    update_slip(mesh, a, displacement[2 * std::size_t(a)], contraction, slip);
    contraction += facet_contraction(edge, temperature, properties, solid_below) *
                   std::abs(mesh.point(b)[0] - mesh.point(a)[0]);
    update_slip(mesh, b, displacement[2 * std::size_t(b)], contraction, slip);
  }
  return slip;
}

PlacedFigure largest_slip(const mesh::Mesh3D& mesh, std::span<const char> solid,
                          std::span<const double> displacement, std::span<const double> temperature,
                          const material::MechanicalProperties& properties, double solid_below) {
  // The contraction between a symmetry plane and a node is at most that of the largest strain.
  double strain = 0.0;
  mesh::for_each_facet(mesh, mesh::PatchKind::bottom, [&](const auto& facet, const auto&) {
    if (solid[std::size_t(facet.element)] != 0)
      strain = std::max(strain, facet_contraction(facet, temperature, properties, solid_below));
  });

  PlacedFigure slip;
  mesh::for_each_facet(mesh, mesh::PatchKind::bottom, [&](const auto& facet, const auto&) {
    if (solid[std::size_t(facet.element)] == 0) return;
    for (int i = 0; i < facet.nodes; ++i) {
      const int n = facet.node[std::size_t(i)];
      for (std::size_t d = 0; d < 2; ++d)
        update_slip(mesh, n, displacement[3 * std::size_t(n) + d], strain * mesh.point(n)[d], slip);
    }
  });
  return slip;
}

template std::vector<double> centroid(const mesh::Mesh<2>&, int);
template std::vector<double> centroid(const mesh::Mesh<3>&, int);
template void merge_turns<2>(const mesh::MergedRows&, std::vector<double>&);
template void merge_turns<3>(const mesh::MergedRows&, std::vector<double>&);
template PlacedFigure largest_rotation(const mesh::Mesh<2>&, std::span<const char>,
                                       std::span<const double>, int, std::vector<double>&);
template PlacedFigure largest_rotation(const mesh::Mesh<3>&, std::span<const char>,
                                       std::span<const double>, int, std::vector<double>&);

}  // namespace dccast::casting
