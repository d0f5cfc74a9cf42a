#pragma once

#include <Eigen/Dense>
#include <array>
#include <cstddef>
#include <vector>

#include "core/fem/element.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::fem {

/// Gradients of the shape functions and weights at every quadrature point of a mesh, contiguous by
/// element, so that assembly streams through memory and never touches coordinates.
template <class Element>
class ElementGeometry {
public:
  static constexpr int dimension = Element::dimension, nodes = Element::nodes,
                       points = Element::points;
  using Gradients = std::array<std::array<double, dimension>, nodes>;  ///< [1/m] by node

  struct Point {
    Gradients gradient;
    double weight;  ///< [m^Dim] quadrature weight times Jacobian, positive
  };
  struct Cell {
    std::array<Point, points> point;
    Gradients mean_gradient;  ///< volume mean over the element, for the B-bar dilatation
    double volume;            ///< [m^Dim]
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
      }
    }
    for (auto& node_gradient : cell.mean_gradient) {
      for (double& g : node_gradient) g /= cell.volume;
    }
  }

  std::vector<Cell> cells_;
};

}  // namespace dccast::fem
