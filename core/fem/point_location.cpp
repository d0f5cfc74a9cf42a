#include "core/fem/point_location.hpp"

#include <algorithm>
#include <cmath>

#include "core/fem/element.hpp"

namespace dccast::fem {

namespace {

/// Distance outside the reference cell at which a point still counts as inside: rounding error of
/// the mapping.
constexpr double slack = 1e-9;

template <int Dim>
using Vector = std::array<double, std::size_t(Dim)>;
template <int Dim>
using Columns = std::array<Vector<Dim>, std::size_t(Dim)>;

double determinant(const Columns<2>& m) {
  return m[0][0] * m[1][1] - m[1][0] * m[0][1];
}

double determinant(const Columns<3>& m) {
  return m[0][0] * (m[1][1] * m[2][2] - m[2][1] * m[1][2]) -
         m[1][0] * (m[0][1] * m[2][2] - m[2][1] * m[0][2]) +
         m[2][0] * (m[0][1] * m[1][2] - m[1][1] * m[0][2]);
}

/// Cramer's rule: sum over d of x[d] columns[d] = right.
template <int Dim>
Vector<Dim> solve(const Columns<Dim>& columns, const Vector<Dim>& right) {
  Vector<Dim> x{};
  const double full_determinant = determinant(columns);
  for (std::size_t d = 0; d < Dim; ++d) {
    Columns<Dim> replaced = columns;
    replaced[d] = right;
    x[d] = determinant(replaced) / full_determinant;
  }
  return x;
}

/// Barycentric coordinates of a point in a triangle or tetrahedron; nothing outside.
template <int Dim>
std::optional<Place> locate_in_simplex(const mesh::Mesh<Dim>& mesh, int e,
                                       const Vector<Dim>& point) {
  const int* node = mesh.nodes_of(e);
  const double* origin = mesh.point(node[0]);
  Columns<Dim> edge;
  Vector<Dim> from_origin;
  for (std::size_t d = 0; d < Dim; ++d) {
    from_origin[d] = point[d] - origin[d];
    for (std::size_t i = 0; i < Dim; ++i) edge[i][d] = mesh.point(node[i + 1])[d] - origin[d];
  }

  // x - x0 = sum of share_i times edge_i.
  const Vector<Dim> share = solve<Dim>(edge, from_origin);

  Place place{e, {}};
  place.shape[0] = 1.0;
  double sum = 0.0;
  for (std::size_t i = 0; i < Dim; ++i) {
    if (share[i] < -slack) return std::nullopt;
    sum += share[i];
    place.shape[0] -= share[i];
    place.shape[i + 1] = share[i];
  }
  return sum > 1.0 + slack ? std::nullopt : std::optional(place);
}

/// Inverts the map of the reference cell by Newton's method; nothing outside. For parallelepipeds
/// one step is exact.
template <int Dim>
std::optional<Place> locate_in_cell(const mesh::Mesh<Dim>& mesh, int e, const Vector<Dim>& point) {
  const int* node = mesh.nodes_of(e);
  Vector<Dim> p{};
  for (int iteration = 0; iteration < 20; ++iteration) {
    const auto shape = Q1<Dim>::shape(p);
    const auto gradient = Q1<Dim>::shape_gradient(p);

    // Residual x(p) - x and Jacobian dx/dp.
    Vector<Dim> residual;
    for (std::size_t d = 0; d < Dim; ++d) residual[d] = -point[d];
    Columns<Dim> jacobian{};
    for (std::size_t i = 0; i < shape.size(); ++i) {
      const double* x = mesh.point(node[i]);
      for (std::size_t d = 0; d < Dim; ++d) {
        residual[d] += shape[i] * x[d];
        for (std::size_t k = 0; k < Dim; ++k) jacobian[k][d] += gradient[i][k] * x[d];
      }
    }

    const Vector<Dim> change = solve<Dim>(jacobian, residual);
    double size = 0.0;
    for (std::size_t d = 0; d < Dim; ++d) {
      p[d] -= change[d];
      size += std::abs(change[d]);
    }
    if (size < 1e-13) break;
  }

  for (const double coordinate : p) {
    if (!(std::abs(coordinate) <= 1.0 + slack)) return std::nullopt;
  }

  Place place{e, {}};
  std::ranges::copy(Q1<Dim>::shape(p), place.shape.begin());
  return place;
}

/// Whether the bounding box of an element contains the point, a test that excludes most elements.
template <int Dim>
bool in_box(const mesh::Mesh<Dim>& mesh, int e, const Vector<Dim>& point) {
  const int* node = mesh.nodes_of(e);
  Vector<Dim> low, high;
  low.fill(INFINITY);
  high.fill(-INFINITY);
  double size = 0.0;
  for (std::size_t d = 0; d < Dim; ++d) {
    for (int i = 0; i < mesh.nodes_per_element; ++i) {
      low[d] = std::min(low[d], mesh.point(node[i])[d]);
      high[d] = std::max(high[d], mesh.point(node[i])[d]);
    }
    size += high[d] - low[d];
  }

  // The slack is relative to the size of the box.
  for (std::size_t d = 0; d < Dim; ++d) {
    if (point[d] < low[d] - slack * size || point[d] > high[d] + slack * size) return false;
  }
  return true;
}

}  // namespace

template <int Dim>
std::optional<Place> locate(const mesh::Mesh<Dim>& mesh,
                            const std::array<double, std::size_t(Dim)>& point) {
  const bool simplices = mesh.nodes_per_element == Dim + 1;
  for (int e = 0; e < mesh.elements(); ++e) {
    if (!in_box<Dim>(mesh, e, point)) continue;

    const auto place =
        simplices ? locate_in_simplex<Dim>(mesh, e, point) : locate_in_cell<Dim>(mesh, e, point);
    if (place) return place;
  }
  return std::nullopt;
}

template std::optional<Place> locate<2>(const mesh::Mesh<2>&, const std::array<double, 2>&);
template std::optional<Place> locate<3>(const mesh::Mesh<3>&, const std::array<double, 3>&);

}  // namespace dccast::fem
