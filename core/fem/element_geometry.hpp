#pragma once

#include <Eigen/Dense>
#include <array>
#include <cstddef>
#include <vector>

#include "core/base/symmetric_tensor.hpp"
#include "core/fem/element.hpp"
#include "core/fem/solid_bending.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::fem {

/// What a point of an axisymmetric element needs besides: the hoop strain of a unit displacement of
/// each node away from the axis, its shape function over the radius [1/m]. Nothing in other
/// elements.
template <class Element, bool = is_axisymmetric<Element>>
struct HoopGradient {};
template <class Element>
struct HoopGradient<Element, true> {
  std::array<double, Element::nodes> hoop;
};

/// How the strain varies within an element: by the gradients of its shape functions at each point.
template <class Element, bool = has_bending_modes<Element>>
struct PointStrain {
  std::array<std::array<double, Element::dimension>, Element::nodes> gradient;  ///< [1/m] by node
};
/// Or by bending modes: their levers at a point.
template <class Element>
struct PointStrain<Element, true> {
  /// Reference coordinates across the first axis of the cell and across the second, each less its
  /// volume mean [1].
  std::array<double, 2> lever;
};
template <>
struct PointStrain<BendingHexahedron, true> {
  std::array<double, SolidBending::levers> lever;  ///< @see SolidBending::lever [1]
};

/// A bending mode of an element: a strain that is linear across an axis of the cell. At a point it
/// is lever times amplitude times strain.
struct BendingMode {
  std::size_t lever;                               ///< which one
  std::array<std::array<double, 2>, 4> amplitude;  ///< of a unit displacement of each node [1/m]
  SymmetricTensor<2> strain;  ///< a stretch and the opposite across the axis [1]
};
template <class Element, bool = has_bending_modes<Element>>
struct BendingModes {};
template <class Element>
struct BendingModes<Element, true> {
  /// Stretch along the first axis and along the second; axisymmetric: also around, across either.
  std::array<BendingMode, is_axisymmetric<Element> ? 4 : 2> bending;
};
template <>
struct BendingModes<BendingHexahedron, true> {
  SolidBending bending;
};
/// Of an axisymmetric element with bending modes, the mean of the hoop gradient, apart from the
/// mean gradient.
template <class Element, bool = is_axisymmetric<Element>&& has_bending_modes<Element>>
struct MeanHoop {};
template <class Element>
struct MeanHoop<Element, true> {
  std::array<double, Element::nodes> mean_hoop;  ///< [1/m] by node
};

/// Gradients of the shape functions and weights at every quadrature point of a mesh, contiguous by
/// element, so that assembly streams through memory and never touches coordinates.
template <class Element>
class ElementGeometry {
public:
  static constexpr int dimension = Element::dimension, nodes = Element::nodes,
                       points = Element::points;
  using Gradients = std::array<std::array<double, dimension>, nodes>;  ///< [1/m] by node

  struct Point : HoopGradient<Element>, PointStrain<Element> {
    double weight;  ///< quadrature weight times Jacobian, positive [m^Dim], axisymmetric: times r
                    ///< [m3/rad]
  };
  struct Cell : BendingModes<Element>, MeanHoop<Element> {
    std::array<Point, points> point;
    /// Volume mean over the element of what a displacement dilates, for the B-bar dilatation: the
    /// gradient, across the axis with the hoop gradient if axisymmetric.
    Gradients mean_gradient;
    double volume;  ///< [m^Dim], axisymmetric: [m3/rad]
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
      if constexpr (is_axisymmetric<Element>) add_radius(mesh, node, q, point);
      cell.volume += point.weight;
      for (std::size_t i = 0; i < std::size_t(nodes); ++i) {
        for (std::size_t a = 0; a < std::size_t(dimension); ++a) {
          double g = 0.0;
          for (std::size_t b = 0; b < std::size_t(dimension); ++b) {
            g += reference[i][b] * inverse(static_cast<int>(b), static_cast<int>(a));
          }
          if constexpr (!has_bending_modes<Element>) point.gradient[i][a] = g;
          cell.mean_gradient[i][a] += point.weight * g;
        }
        if constexpr (is_axisymmetric<Element>)
          cell.mean_gradient[i][0] += point.weight * point.hoop[i];
      }
    }
    for (auto& node_gradient : cell.mean_gradient) {
      for (double& g : node_gradient) g /= cell.volume;
    }
    if constexpr (has_bending_modes<Element>) add_bending_modes(mesh, node, cell);
  }

  static void add_bending_modes(const mesh::Mesh<3>& mesh, const int* node, Cell& cell) {
    std::array<Eigen::Vector3d, 8> corner;
    for (std::size_t i = 0; i < 8; ++i) {
      corner[i] = Eigen::Map<const Eigen::Vector3d>(mesh.point(node[i]));
    }
    cell.bending = SolidBending(corner);
    std::array<double, SolidBending::levers> mean{};
    for (std::size_t q = 0; q < std::size_t(points); ++q) {
      cell.point[q].lever = SolidBending::lever(Element::point[q]);
      for (std::size_t l = 0; l < mean.size(); ++l) {
        mean[l] += cell.point[q].weight * cell.point[q].lever[l] / cell.volume;
      }
    }
    for (Point& point : cell.point) {
      for (std::size_t l = 0; l < mean.size(); ++l) point.lever[l] -= mean[l];
    }
  }

  /// Axes of the cell at its centre, g_1 = dx/d xi and g_2 = dx/d eta, and what of a displacement
  /// is neither a translation nor a uniform gradient: q xi eta with q the sum of gamma_i u_i
  /// (Flanagan and Belytschko 1981). Along g_1 it is a strain g_1.q / |g_1|^2 eta, along g_2 the
  /// same with xi.
  static void add_bending_modes(const mesh::Mesh<2>& mesh, const int* node, Cell& cell) {
    const auto reference = Element::shape_gradient({0.0, 0.0});
    Eigen::Matrix2d axes = Eigen::Matrix2d::Zero();  // columns g_1 and g_2
    Eigen::Vector2d warp =
        Eigen::Vector2d::Zero();  // of the cell itself: x has the part warp xi eta
    std::array<double, 4> hourglass;
    for (std::size_t i = 0; i < 4; ++i) {
      hourglass[i] = 4.0 * reference[i][0] * reference[i][1];
      const Eigen::Map<const Eigen::Vector2d> x(mesh.point(node[i]));
      axes += x * Eigen::RowVector2d(reference[i][0], reference[i][1]);
      warp += hourglass[i] * x;
    }
    const Eigen::Vector2d share = axes.inverse() * warp;
    set_levers(cell);
    for (std::size_t m = 0; m < 2; ++m) {
      const Eigen::Vector2d axis = axes.col(static_cast<int>(m));
      const double square = axis.squaredNorm();
      BendingMode& mode = cell.bending[m];
      mode.lever = m;
      for (std::size_t i = 0; i < 4; ++i) {
        const double gamma = hourglass[i] - share(0) * reference[i][0] - share(1) * reference[i][1];
        mode.amplitude[i] = {gamma * axis(0) / square, gamma * axis(1) / square};
      }
      const double along = axis(0) * axis(0) / square, across = axis(1) * axis(1) / square;
      const double shear = axis(0) * axis(1) / square;
      mode.strain = {{along - across, across - along, 0.0, 2.0 * shear}};
      if constexpr (is_axisymmetric<Element>) {
        add_hoop_mode(cell, m);
        cell.bending[2 + m].strain = {{-across, -along, 1.0, shear}};
      }
    }
  }

  static void set_levers(Cell& cell) {
    std::array<double, 2> mean{};
    for (std::size_t q = 0; q < std::size_t(points); ++q) {
      // Across the first axis runs the second coordinate.
      cell.point[q].lever = {Element::point[q][1], Element::point[q][0]};
      for (std::size_t m = 0; m < 2; ++m) {
        mean[m] += cell.point[q].weight * cell.point[q].lever[m] / cell.volume;
      }
    }
    for (Point& point : cell.point) {
      for (std::size_t m = 0; m < 2; ++m) point.lever[m] -= mean[m];
    }
  }

  /// The hoop strain varies across an axis by what its points say of it. The mean of it stays.
  static void add_hoop_mode(Cell& cell, std::size_t lever) {
    BendingMode& mode = cell.bending[2 + lever];
    mode.lever = lever;
    mode.amplitude = {};
    cell.mean_hoop = {};
    double square = 0.0;
    for (const Point& point : cell.point) {
      square += point.weight * point.lever[lever] * point.lever[lever];
    }
    for (const Point& point : cell.point) {
      for (std::size_t i = 0; i < std::size_t(nodes); ++i) {
        cell.mean_hoop[i] += point.weight * point.hoop[i] / cell.volume;
        mode.amplitude[i][0] += point.weight * point.lever[lever] * point.hoop[i] / square;
      }
    }
  }

  static void add_radius(const mesh::Mesh<dimension>& mesh, const int* node, std::size_t q,
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

}  // namespace dccast::fem
