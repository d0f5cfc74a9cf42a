#pragma once

#include <Eigen/Dense>
#include <array>
#include <cstddef>
#include <vector>

#include "core/fem/element.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::fem {

/// What a point of a ring needs besides: the hoop strain of a unit displacement of each node away from
/// the axis, its shape function over the radius [1/m]. Nothing in other elements.
template <class Element, bool = is_ring<Element>>
struct HoopGradient {};
template <class Element>
struct HoopGradient<Element, true> {
  std::array<double, Element::nodes> hoop;
};

/// Gradients of the shape functions and weights at every quadrature point of a mesh, contiguous by
/// element, so that assembly streams through memory and never touches coordinates.
template <class Element>
class ElementGeometry {
public:
  static constexpr int dimension = Element::dimension, nodes = Element::nodes,
                       points = Element::points;
  using Gradients = std::array<std::array<double, dimension>, nodes>;  ///< [1/m] by node

  struct Point : HoopGradient<Element> {
    Gradients gradient;
    double weight;  ///< quadrature weight times Jacobian, positive [m^Dim], in a ring times r [m3/rad]
  };
  struct Cell {
    std::array<Point, points> point;
    /// Volume mean over the element of what a displacement dilates, for the B-bar dilatation: the
    /// gradient, in a ring and across with the hoop gradient.
    Gradients mean_gradient;
    double volume;  ///< [m^Dim], of a ring [m3/rad]
  };

  /// Computes the elements from `first` on; call with the first element that moved or is new.
  void update(const mesh::Mesh<dimension>& mesh, int first = 0) {
    cells_.resize(std::size_t(mesh.elements()));
    for (int e = first; e < mesh.elements(); ++e) compute(mesh, e, cells_[std::size_t(e)]);
  }

  int elements() const { return static_cast<int>(cells_.size()); }
  const Cell& cell(int e) const { return cells_[std::size_t(e)]; }

private:
  static void compute(const mesh::Mesh<dimension>& mesh, int e, Cell& cell) {
    const int* node = mesh.nodes_of(e);
    cell.volume = 0.0;
    cell.mean_gradient = {};
    for (std::size_t q = 0; q < std::size_t(points); ++q) {
      const auto reference = Element::shape_gradient(Element::point[q]);
      Eigen::Matrix<double, dimension, dimension> jacobian;  // d x_a / d xi_b
      jacobian.setZero();
      for (std::size_t i = 0; i < std::size_t(nodes); ++i) {
        const double* x = mesh.point(node[i]);
        for (int a = 0; a < dimension; ++a) {
          for (int b = 0; b < dimension; ++b) jacobian(a, b) += x[a] * reference[i][std::size_t(b)];
        }
      }
      const Eigen::Matrix<double, dimension, dimension> inverse = jacobian.inverse();
      Point& point = cell.point[q];
      point.weight = Element::weight[q] * jacobian.determinant();
      if constexpr (is_ring<Element>) turn(mesh, node, q, point);
      cell.volume += point.weight;
      for (std::size_t i = 0; i < std::size_t(nodes); ++i) {
        for (std::size_t a = 0; a < std::size_t(dimension); ++a) {
          double g = 0.0;
          for (std::size_t b = 0; b < std::size_t(dimension); ++b) {
            g += reference[i][b] * inverse(static_cast<int>(b), static_cast<int>(a));
          }
          point.gradient[i][a] = g;
          cell.mean_gradient[i][a] += point.weight * g;
        }
        if constexpr (is_ring<Element>) cell.mean_gradient[i][0] += point.weight * point.hoop[i];
      }
    }
    for (auto& node_gradient : cell.mean_gradient) {
      for (double& g : node_gradient) g /= cell.volume;
    }
  }

  static void turn(const mesh::Mesh<dimension>& mesh, const int* node, std::size_t q,
                   Point& point) {
    point.hoop = Element::shape(Element::point[q]);
    double radius = 0.0;
    for (std::size_t i = 0; i < std::size_t(nodes); ++i) {
      radius += point.hoop[i] * mesh.point(node[i])[0];
    }
    for (double& share : point.hoop) share /= radius;
    point.weight *= radius;
  }

  std::vector<Cell> cells_;
};

/// Integrals of the two shape functions of an edge from `a` to `b` [m]; in a ring times r [m2/rad].
template <class Element>
std::array<double, 2> edge_shares(const double* a, const double* b) {
  const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
  if constexpr (is_ring<Element>) {
    return {length * (2.0 * a[0] + b[0]) / 6.0, length * (a[0] + 2.0 * b[0]) / 6.0};
  } else {
    return {0.5 * length, 0.5 * length};
  }
}

}  // namespace dccast::fem
