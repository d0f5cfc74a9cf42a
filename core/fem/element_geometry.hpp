#pragma once

#include <Eigen/Dense>
#include <array>
#include <bit>
#include <cstddef>
#include <vector>

#include "core/base/instructions.hpp"
#include "core/base/tensors.hpp"
#include "core/fem/element.hpp"
#include "core/fem/solid_bending.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::fem {

/// Additional data of a point of an axisymmetric element: the hoop strain per unit radial
/// displacement of each node, its shape function divided by the radius [1/m]. Empty for other
/// elements.
template <class Element, class Number, bool = is_axisymmetric<Element>>
struct HoopGradient {};
template <class Element, class Number>
struct HoopGradient<Element, Number, true> {
  /// (node) N_i / r [1/m].
  std::array<Number, Element::nodes> hoop;
};

/// Variation of the strain within an element: the gradients of its shape functions at a point.
template <class Element, class Number, bool = has_bending_modes<Element>>
struct PointStrain {
  std::array<std::array<Number, Element::dimension>, Element::nodes> gradient;  ///< [1/m] by node
};
/// For elements with bending modes: the values of their levers at a point.
template <class Element, class Number>
struct PointStrain<Element, Number, true> {
  /// Reference coordinates transverse to the first and to the second axis of the cell, each minus
  /// its volume mean [1].
  std::array<Number, 2> lever;
};
/// The hexahedron has a lever for each pair of axis and product of axes.
template <class Number>
struct PointStrain<BendingHexahedron, Number, true> {
  std::array<Number, SolidBending::levers> lever;  ///< @see SolidBending::lever [1]
};

/// A bending mode of an element: a strain that varies linearly across an axis of the cell. At a
/// point it is lever times amplitude times strain.
template <class Number>
struct BendingMode {
  std::array<std::array<Number, 2>, 4> amplitude;  ///< per unit displacement of each node [1/m]
  SymmetricTensor<2, Number> strain;  ///< a stretch with the opposite transverse strain [1]
};
/// The bending modes of an element; empty for elements without.
template <class Element, class Number, bool = has_bending_modes<Element>>
struct BendingModes {};
template <class Element, class Number>
struct BendingModes<Element, Number, true> {
  /// Stretch along the first and along the second axis; axisymmetric: also hoop stretches that vary
  /// across either axis.
  std::array<BendingMode<Number>, is_axisymmetric<Element> ? 4 : 2> bending;
  /// Index of the lever of a mode.
  static constexpr std::size_t lever_of(std::size_t mode) { return mode % 2; }
};
template <class Number>
struct BendingModes<BendingHexahedron, Number, true> {
  /// Warps and modes by which the amplitudes follow from nodal displacements.
  SolidBendingModes<Number> bending;
};
/// For an axisymmetric element with bending modes: the mean of the hoop gradient, separate from the
/// mean gradient.
template <class Element, class Number, bool = is_axisymmetric<Element>&& has_bending_modes<Element>>
struct MeanHoop {};
template <class Element, class Number>
struct MeanHoop<Element, Number, true> {
  std::array<Number, Element::nodes> mean_hoop;  ///< [1/m] by node
};

/// The geometry of an element as needed by mechanics, or of several with Lanes as Number: plain
/// numbers only.
template <class Element, class Number = double>
struct ElementCell : BendingModes<Element, Number>, MeanHoop<Element, Number> {
  /// An integration point.
  struct Point : HoopGradient<Element, Number>, PointStrain<Element, Number> {
    /// Quadrature weight times Jacobian, positive [m^Dim], axisymmetric: times r [m3/rad]
    Number weight;
  };
  using Gradients =
      std::array<std::array<Number, Element::dimension>, Element::nodes>;  ///< [1/m] by node

  /// (integration point)
  std::array<Point, Element::points> point;
  /// Volume mean of the derivative of the dilatation by the nodal displacements, for the B-bar
  /// dilatation [1/m]: the gradient, plus the hoop gradient in the radial direction if
  /// axisymmetric.
  Gradients mean_gradient;
  Number volume;  ///< [m^Dim], axisymmetric: [m3/rad]
};

/// Gradients of the shape functions and weights at every quadrature point of a mesh, so that
/// assembly streams through memory and never reads coordinates. Consecutive elements share the
/// lanes of a register: register_lanes() of them form a group.
template <class Element>
class ElementGeometry {
public:
  static constexpr int dimension = Element::dimension, nodes = Element::nodes,
                       points = Element::points;
  /// Kinds of an element's data, as plain numbers.
  using Cell = ElementCell<Element>;
  using Point = typename Cell::Point;
  using Gradients = typename Cell::Gradients;

  /// Computes the elements from `first` on; call with the first element that moved or is new.
  void update(const mesh::Mesh<dimension>& mesh, int first = 0) {
    elements_ = mesh.elements();
    const std::size_t groups = (std::size_t(elements_) + lanes() - 1) / lanes();
    line_.resize((groups * lanes() * numbers + line_size - 1) / line_size);
    Cell cell{};
    for (int e = first; e < elements_; ++e) {
      compute(mesh, e, cell);
      store(std::size_t(e), cell);
    }
    if (first >= elements_) return;

    // The last group is filled up with copies of the last element.
    for (std::size_t e = std::size_t(elements_); e < groups * lanes(); ++e) store(e, cell);
  }

  int elements() const { return elements_; }
  /// Geometry of one element.
  Cell cell(int e) const {
    std::array<double, numbers> number;
    const double* from = lane(std::size_t(e));
    for (std::size_t k = 0; k < numbers; ++k) number[k] = from[k * lanes()];
    return std::bit_cast<Cell>(number);
  }
  /// @see ElementCell::mean_gradient
  Gradients mean_gradient(int e) const {
    const double* from = lane(std::size_t(e)) + (numbers - 1 - nodes * dimension) * lanes();
    Gradients gradient;
    for (auto& node_gradient : gradient) {
      for (double& g : node_gradient) {
        g = *from;
        from += lanes();
      }
    }
    return gradient;
  }
  /// Volume of an element [m^Dim], axisymmetric: [m3/rad].
  double volume(int e) const { return lane(std::size_t(e))[(numbers - 1) * lanes()]; }
  /// A group of elements; the last group of a mesh is padded with its last element.
  /// @tparam Count  register_lanes()
  /// @param first   number of its first element
  template <int Count>
  const ElementCell<Element, Lanes<Count>>& group(std::size_t first) const {
    using Group = ElementCell<Element, Lanes<Count>>;
    static_assert(sizeof(Group) == Count * sizeof(Cell));
    return *reinterpret_cast<const Group*>(lane(first));
  }

private:
  /// Doubles of a cell, and of a cache line.
  static constexpr std::size_t numbers = sizeof(Cell) / sizeof(double), line_size = 8;
  /// Storage of whole cache lines, so that groups can be loaded with aligned access.
  struct alignas(64) Line {
    double number[line_size];  ///< members of cells, each in its unit
  };

  /// Elements of a group: the lanes of the widest register of this processor.
  static std::size_t lanes() { return std::size_t(register_lanes()); }
  /// Index of the first number of an element; its further numbers follow at a distance of lanes().
  static std::size_t first_number(std::size_t e) {
    return e / lanes() * lanes() * numbers + e % lanes();
  }
  /// First number of an element, in the unit of the first member of its cell.
  const double* lane(std::size_t e) const {
    return reinterpret_cast<const double*>(line_.data()) + first_number(e);
  }
  /// Writes the numbers of an element into its lane of its group.
  void store(std::size_t e, const Cell& cell) {
    const auto number = std::bit_cast<std::array<double, numbers>>(cell);
    double* to = reinterpret_cast<double*>(line_.data()) + first_number(e);
    for (std::size_t k = 0; k < numbers; ++k) to[k * lanes()] = number[k];
  }

  /// Computes gradients, weights and volume of an element from the coordinates of its nodes.
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

      // grad N_i = (dN_i / d xi) (dx / d xi)^-1, and its sum for the volume mean.
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

  /// Bending modes of a hexahedron from the coordinates of its corners; see SolidBending.
  static void add_bending_modes(const mesh::Mesh<3>& mesh, const int* node, Cell& cell) {
    std::array<Eigen::Vector3d, 8> corner;
    for (std::size_t i = 0; i < 8; ++i) {
      corner[i] = Eigen::Map<const Eigen::Vector3d>(mesh.point(node[i]));
    }
    cell.bending = SolidBending(corner);
    set_levers(cell, SolidBending::lever);
  }

  /// Axes of the cell at its centre, g_1 = dx/d xi and g_2 = dx/d eta, and the hourglass part of
  /// the displacement, which is neither a translation nor a uniform gradient: q xi eta with q the
  /// sum of gamma_i u_i (Flanagan and Belytschko 1981). It causes a strain g_1.q / |g_1|^2 eta
  /// along g_1, and the same with xi along g_2.
  static void add_bending_modes(const mesh::Mesh<2>& mesh, const int* node, Cell& cell) {
    const auto reference = Element::shape_gradient({0.0, 0.0});
    Eigen::Matrix2d axes = Eigen::Matrix2d::Zero();  // columns g_1 and g_2
    // Hourglass part of the coordinates: x contains warp xi eta.
    Eigen::Vector2d warp = Eigen::Vector2d::Zero();
    std::array<double, 4> hourglass;
    for (std::size_t i = 0; i < 4; ++i) {
      hourglass[i] = 4.0 * reference[i][0] * reference[i][1];
      const Eigen::Map<const Eigen::Vector2d> x(mesh.point(node[i]));
      axes += x * Eigen::RowVector2d(reference[i][0], reference[i][1]);
      warp += hourglass[i] * x;
    }
    const Eigen::Vector2d share = axes.inverse() * warp;

    // The second coordinate varies across the first axis.
    set_levers(cell, [](const auto& p) { return std::array{p[1], p[0]}; });

    for (std::size_t m = 0; m < 2; ++m) {
      const Eigen::Vector2d axis = axes.col(static_cast<int>(m));
      const double square = axis.squaredNorm();
      BendingMode<double>& mode = cell.bending[m];
      for (std::size_t i = 0; i < 4; ++i) {
        const double gamma = hourglass[i] - share(0) * reference[i][0] - share(1) * reference[i][1];
        mode.amplitude[i] = {gamma * axis(0) / square, gamma * axis(1) / square};
      }

      // A stretch along the axis with the opposite transverse strain, in the global axes.
      const double along = axis(0) * axis(0) / square, across = axis(1) * axis(1) / square;
      const double shear = axis(0) * axis(1) / square;
      mode.strain = {{along - across, across - along, 0.0, 2.0 * shear}};

      if constexpr (is_axisymmetric<Element>) {
        add_hoop_mode(cell, m);
        cell.bending[2 + m].strain = {{-across, -along, 1.0, shear}};
      }
    }
  }

  /// Sets the levers at the points, minus their volume means. @param lever_at  returns those of a
  /// reference point
  template <class LeverAt>
  static void set_levers(Cell& cell, const LeverAt& lever_at) {
    decltype(Point::lever) mean{};
    for (std::size_t q = 0; q < std::size_t(points); ++q) {
      cell.point[q].lever = lever_at(Element::point[q]);
      for (std::size_t l = 0; l < mean.size(); ++l) {
        mean[l] += cell.point[q].weight * cell.point[q].lever[l] / cell.volume;
      }
    }

    for (Point& point : cell.point) {
      for (std::size_t l = 0; l < mean.size(); ++l) point.lever[l] -= mean[l];
    }
  }

  /// Adds a mode with the variation of the hoop strain across an axis, taken from its values at the
  /// points. Its mean is unchanged.
  static void add_hoop_mode(Cell& cell, std::size_t lever) {
    BendingMode<double>& mode = cell.bending[2 + lever];
    mode.amplitude = {};
    cell.mean_hoop = {};

    // Least squares: the slope of the hoop strain over the lever.
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

  /// Hoop gradient of a point, and its weight times the radius.
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

  int elements_ = 0;
  std::vector<Line> line_;  ///< (group of elements, number within a cell, lane)
};

}  // namespace dccast::fem
