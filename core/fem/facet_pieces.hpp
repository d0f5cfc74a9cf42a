#pragma once

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "core/fem/element.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::fem {

/// Integrals by node of a facet [m^(Dim-1)], axisymmetric [m2/rad]: two for an edge, four for a
/// face; the last one of a triangle is zero.
template <int Dim>
using FacetShares = std::array<double, Dim == 2 ? 2 : 4>;

/// Integrals of the shape functions of an edge [m].
inline FacetShares<2> facet_shares(const mesh::Mesh<2>& mesh, const mesh::Facet<2>& facet) {
  const double *a = mesh.point(facet.node[0]), *b = mesh.point(facet.node[1]);
  const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
  return {0.5 * length, 0.5 * length};
}

namespace detail {
/// Coordinates of a corner of a facet [m].
inline Eigen::Vector3d corner_point(const mesh::Mesh<3>& mesh, const mesh::Facet<3>& facet,
                                    std::size_t i) {
  return Eigen::Map<const Eigen::Vector3d>(mesh.point(facet.node[i]));
}

/// Normal vector of a triangle with twice its area as length [m2].
inline Eigen::Vector3d doubled_area(const mesh::Mesh<3>& mesh, const mesh::Facet<3>& facet) {
  const Eigen::Vector3d a = corner_point(mesh, facet, 0);
  return (corner_point(mesh, facet, 1) - a).cross(corner_point(mesh, facet, 2) - a);
}

/// Calls use(shape functions, area vector) at the 2 x 2 Gauss points of a quadrilateral; the area
/// vector points along the normal [m2].
template <class Use>
void for_each_gauss_point(const mesh::Mesh<3>& mesh, const mesh::Facet<3>& facet, const Use& use) {
  for (const auto& p : Q1Quadrilateral::point) {
    const auto gradient = Q1Quadrilateral::shape_gradient(p);
    Eigen::Vector3d along = Eigen::Vector3d::Zero(), across = along;
    for (std::size_t i = 0; i < 4; ++i) {
      along += gradient[i][0] * corner_point(mesh, facet, i);
      across += gradient[i][1] * corner_point(mesh, facet, i);
    }
    const Eigen::Vector3d area = along.cross(across);
    use(Q1Quadrilateral::shape(p), area);
  }
}
}  // namespace detail

/// Integrals of the shape functions of a triangle or of a quadrilateral, which need not be plane
/// [m2]; the latter by 2 x 2 Gauss points.
inline FacetShares<3> facet_shares(const mesh::Mesh<3>& mesh, const mesh::Facet<3>& facet) {
  // A triangle is plane: each node has a third of its area.
  if (facet.nodes == 3) {
    const double third = detail::doubled_area(mesh, facet).norm() / 6.0;
    return {third, third, third, 0.0};
  }

  FacetShares<3> shares{};
  detail::for_each_gauss_point(mesh, facet, [&](const auto& shape, const Eigen::Vector3d& area) {
    const double size = area.norm();
    for (std::size_t i = 0; i < 4; ++i) shares[i] += shape[i] * size;
  });
  return shares;
}

/// Integrals of the shape functions of a facet of an element [m^(Dim-1)], axisymmetric: [m2/rad].
template <class Element>
FacetShares<Element::dimension> facet_shares_of(const mesh::Mesh<Element::dimension>& mesh,
                                                const mesh::Facet<Element::dimension>& facet) {
  if constexpr (is_axisymmetric<Element>) {  // times the radius, coordinate 0
    const double *a = mesh.point(facet.node[0]), *b = mesh.point(facet.node[1]);
    const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
    return {length * (2.0 * a[0] + b[0]) / 6.0, length * (a[0] + 2.0 * b[0]) / 6.0};
  } else {
    return facet_shares(mesh, facet);
  }
}

/// (node of a facet) vectors along the coordinate axes.
template <int Dim>
using FacetVectors = std::array<std::array<double, std::size_t(Dim)>, Dim == 2 ? 2 : 4>;

/// Nodal forces of a pressure that is linear over a facet and pushes against it from outside
/// [N/m], axisymmetric [N/rad], of a solid [N].
/// @param pressure  (node of the facet) [Pa]
template <class Element>
FacetVectors<2> pressure_forces(const mesh::Mesh<2>& mesh, const mesh::Facet<2>& facet,
                                std::span<const double> pressure) {
  const double *a = mesh.point(facet.node[0]), *b = mesh.point(facet.node[1]);
  const std::array<double, 2> inward{a[1] - b[1], b[0] - a[0]};  // times the length

  // Two Gauss points are exact for the product of shape function, pressure and radius.
  FacetVectors<2> force{};
  for (const double sign : {-1.0, 1.0}) {
    const double xi = 0.5 + sign * 0.5 / std::sqrt(3.0);
    const std::array<double, 2> shape{1.0 - xi, xi};
    double share = 0.5 * (shape[0] * pressure[0] + shape[1] * pressure[1]);
    if constexpr (is_axisymmetric<Element>) share *= shape[0] * a[0] + shape[1] * b[0];
    for (std::size_t i = 0; i < 2; ++i)
      for (std::size_t d = 0; d < 2; ++d) force[i][d] += shape[i] * share * inward[d];
  }
  return force;
}
template <class Element>
FacetVectors<3> pressure_forces(const mesh::Mesh<3>& mesh, const mesh::Facet<3>& facet,
                                std::span<const double> pressure) {
  FacetVectors<3> force{};
  const auto push = [&](std::size_t node, double share, const Eigen::Vector3d& outward) {
    for (std::size_t d = 0; d < 3; ++d) force[node][d] -= share * outward[Eigen::Index(d)];
  };

  if (facet.nodes == 3) {
    const Eigen::Vector3d area = 0.5 * detail::doubled_area(mesh, facet);
    const double sum = pressure[0] + pressure[1] + pressure[2];
    for (std::size_t i = 0; i < 3; ++i) push(i, (sum + pressure[i]) / 12.0, area);
    return force;
  }

  detail::for_each_gauss_point(mesh, facet, [&](const auto& shape, const Eigen::Vector3d& area) {
    double at_point = 0.0;
    for (std::size_t i = 0; i < 4; ++i) at_point += shape[i] * pressure[i];
    for (std::size_t i = 0; i < 4; ++i) push(i, shape[i] * at_point, area);
  });
  return force;
}

/// A facet is cut into pieces where a nodal quantity passes given levels, and the shape functions
/// are integrated over every piece. The pieces cover the facet exactly and change continuously with
/// every level.
///
/// Units: levels in any unit; reference coordinates, weights on the reference cell and shares of
/// corners [1].

/// A piece of an edge between two levels.
struct EdgePiece {
  /// (Gauss point) [unit of the levels]. Two points are exact up to cubic polynomials: the product
  /// of a shape function, the radius and a quantity that is linear along the edge.
  std::array<double, 2> level;
  /// (node, Gauss point) [m], axisymmetric [m2/rad]
  std::array<std::array<double, 2>, 2> weight;
  double middle_level;  ///< [unit of the levels]
};

/// A piece of a face between two levels.
struct FacePiece {
  std::array<double, 4> weight;  ///< integral of the shape function, by node [m2]
  /// (node) mean level weighted by the shape function [unit of the levels]: a law linear in the
  /// level, evaluated there, is integrated exactly.
  std::array<double, 4> level;
  double area;          ///< [m2]
  double middle_level;  ///< mean over the piece [unit of the levels]
};

/// An edge with the reference coordinate xi from 0 at its first node to 1 at its second.
class EdgeCut {
public:
  /// @param level   at the two nodes, by which the edge is cut
  /// @param radius  at the two nodes [m]; {1, 1} unless the section is axisymmetric
  /// @param length  [m]
  EdgeCut(double length, std::array<double, 2> level, std::array<double, 2> radius)
      : length_(length), level_(level), radius_(radius) {}

  /// Calls `use(EdgePiece)` for every piece. @param levels  in ascending order
  template <class Use>
  void for_each_piece(std::span<const double> levels, const Use& use) const {
    const double rise = level_[1] - level_[0];
    double begin = 0.0;

    const auto cut_at = [&](double level) {
      const double xi = (level - level_[0]) / rise;
      if (!(xi > begin && xi < 1.0)) return;
      use(piece(begin, xi));
      begin = xi;
    };

    if (rise > 0.0) {
      std::for_each(levels.begin(), levels.end(), cut_at);
    } else if (rise < 0.0) {
      std::for_each(levels.rbegin(), levels.rend(), cut_at);
    }

    use(piece(begin, 1.0));
  }

private:
  /// Level at the reference coordinate xi, linear along the edge.
  double level_at(double xi) const { return level_[0] + xi * (level_[1] - level_[0]); }
  /// Radius at the reference coordinate xi [m]; 1 unless axisymmetric.
  double radius_at(double xi) const { return radius_[0] + xi * (radius_[1] - radius_[0]); }

  /// Integrates the part of the edge between two reference coordinates.
  EdgePiece piece(double begin, double end) const {
    const double half = 0.5 * (end - begin), middle = 0.5 * (begin + end);
    const double offset = half / std::sqrt(3.0);
    const std::array<double, 2> gauss_point{middle - offset, middle + offset};

    // Two Gauss points are exact for the product of shape function, radius and level.
    EdgePiece piece;
    for (std::size_t g = 0; g < 2; ++g) {
      const double xi = gauss_point[g];
      for (std::size_t n = 0; n < 2; ++n)
        piece.weight[n][g] = half * length_ * (n == 0 ? 1.0 - xi : xi) * radius_at(xi);
      piece.level[g] = level_at(xi);
    }
    piece.middle_level = level_at(middle);
    return piece;
  }

  double length_;  ///< [m]
  std::array<double, 2> level_;
  std::array<double, 2> radius_;  ///< [m]
};

/// A triangle or a quadrilateral, which need not be plane. Cut lines are straight in the reference
/// coordinates of a triangle; a quadrilateral is cut as two triangles. On a vertical rectangle they
/// are exact lines of equal height.
class FaceCut {
public:
  /// @param level  (node of the facet) by which the face is cut
  FaceCut(const mesh::Mesh<3>& mesh, const mesh::Facet<3>& facet, std::array<double, 4> level)
      : nodes_(facet.nodes), level_(level) {
    for (std::size_t i = 0; i < std::size_t(nodes_); ++i)
      corner_[i] = Eigen::Map<const Eigen::Vector3d>(mesh.point(facet.node[i]));
  }

  /// Calls `use(FacePiece)` for every piece. @param levels  in ascending order
  template <class Use>
  void for_each_piece(std::span<const double> levels, const Use& use) const {
    const auto [low, high] = std::minmax_element(level_.begin(), level_.begin() + nodes_);
    double begin = -INFINITY;

    const auto cut_at = [&](double end) {
      const FacePiece piece = integrate_between(begin, end);
      if (piece.area > 0.0) use(piece);
      begin = end;
    };

    for (const double level : levels)
      if (level > *low && level < *high && level > begin) cut_at(level);
    cut_at(INFINITY);
  }

private:
  /// A corner of a polygon in reference coordinates.
  struct Corner {
    /// The reference coordinates of the cell; a cut lies between its corners.
    std::array<double, 2> reference;
    double level;
  };
  /// The corners of a convex polygon, in order.
  using Polygon = std::vector<Corner>;

  /// The piece between two levels, which may be infinite.
  FacePiece integrate_between(double from, double to) const {
    FacePiece sum{};
    for (std::size_t half = 0; half < std::size_t(nodes_ - 2); ++half) {
      Polygon polygon{reference_corner(0), reference_corner(half + 1), reference_corner(half + 2)};
      if (from > -INFINITY) polygon = clip(polygon, from, 1.0);
      if (to < INFINITY) polygon = clip(polygon, to, -1.0);

      // The polygon is convex: a fan of triangles.
      for (std::size_t i = 2; i < polygon.size(); ++i)
        add_triangle({polygon[0], polygon[i - 1], polygon[i]}, sum);
    }

    for (std::size_t n = 0; n < 4; ++n)
      sum.level[n] = sum.weight[n] > 0.0 ? sum.level[n] / sum.weight[n] : 0.0;
    if (sum.area > 0.0) sum.middle_level /= sum.area;
    return sum;
  }

  /// Corner of the whole face. @param i  number of its node
  Corner reference_corner(std::size_t i) const {
    if (nodes_ == 3) return {{i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0}, level_[i]};
    return {{detail::corner[i][0], detail::corner[i][1]}, level_[i]};
  }

  /// The part of a convex polygon above a level (sign 1) or below it (sign -1).
  static Polygon clip(const Polygon& polygon, double level, double sign) {
    Polygon kept;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Corner &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
      const double above_a = sign * (a.level - level), above_b = sign * (b.level - level);
      if (above_a >= 0.0) kept.push_back(a);
      if (above_a * above_b >= 0.0) continue;

      // The side crosses the level.
      const double share = above_a / (above_a - above_b);
      kept.push_back({{a.reference[0] + share * (b.reference[0] - a.reference[0]),
                       a.reference[1] + share * (b.reference[1] - a.reference[1])},
                      level});
    }
    return kept;
  }

  /// Seven points, exact up to polynomials of degree five (Radon 1948): enough for the product of
  /// shape function, Jacobian and level of a plane quadrilateral.
  struct Radon {
    double weight;                ///< [1] they sum to 1
    std::array<double, 3> share;  ///< barycentric coordinates [1]
  };
  /// The points of Radon's rule, from sqrt(15).
  static std::array<Radon, 7> radon() {
    const double root = std::sqrt(15.0);
    std::array<Radon, 7> points;
    points[0] = {9.0 / 40.0, {1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0}};

    // Two groups of three points, symmetric about the centroid.
    for (std::size_t k = 0; k < 2; ++k) {
      const double sign = k == 0 ? -1.0 : 1.0;
      const double near = (6.0 + sign * root) / 21.0, weight = (155.0 + sign * root) / 1200.0;
      for (std::size_t i = 0; i < 3; ++i) {
        Radon& point = points[1 + 3 * k + i];
        point = {weight, {near, near, near}};
        point.share[i] = 1.0 - 2.0 * near;
      }
    }
    return points;
  }

  /// Adds the integrals over a triangle in reference coordinates.
  /// @param triangle  corners with their levels
  /// @param sum       weights, weighted levels and area of the piece so far
  void add_triangle(const std::array<Corner, 3>& triangle, FacePiece& sum) const {
    static const std::array<Radon, 7> points = radon();
    const auto& [a, b, c] = triangle;
    const double reference_area =
        0.5 * ((b.reference[0] - a.reference[0]) * (c.reference[1] - a.reference[1]) -
               (b.reference[1] - a.reference[1]) * (c.reference[0] - a.reference[0]));

    // The piece of a facet is a triangle in its reference coordinates.
    for (const Radon& point : points) {
      std::array<double, 2> reference{};
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t d = 0; d < 2; ++d)
          reference[d] += point.share[i] * triangle[i].reference[d];
      }
      add_point(reference, point.weight * reference_area, sum);
    }
  }

  /// Adds an integration point. @param weight  in the reference coordinates [1]
  void add_point(const std::array<double, 2>& reference, double weight, FacePiece& sum) const {
    std::array<double, 4> shape{};
    std::array<std::array<double, 2>, 4> gradient{};
    if (nodes_ == 3) {
      std::ranges::copy(P1Triangle::shape(reference), shape.begin());
      std::ranges::copy(P1Triangle::shape_gradient(reference), gradient.begin());
    } else {
      shape = Q1Quadrilateral::shape(reference);
      gradient = Q1Quadrilateral::shape_gradient(reference);
    }

    // Tangents of the facet in space; their product is the area per reference area.
    Eigen::Vector3d along = Eigen::Vector3d::Zero(), across = along;
    double level = 0.0;
    for (std::size_t i = 0; i < std::size_t(nodes_); ++i) {
      along += gradient[i][0] * corner_[i];
      across += gradient[i][1] * corner_[i];
      level += shape[i] * level_[i];
    }

    weight *= along.cross(across).norm();
    sum.area += weight;
    sum.middle_level += weight * level;
    for (std::size_t i = 0; i < std::size_t(nodes_); ++i) {
      sum.weight[i] += weight * shape[i];
      sum.level[i] += weight * shape[i] * level;
    }
  }

  /// Three or four.
  int nodes_;
  /// (node) level by which the face is cut.
  std::array<double, 4> level_;
  std::array<Eigen::Vector3d, 4> corner_;  ///< [m]
};

}  // namespace dccast::fem
