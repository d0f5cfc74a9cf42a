#pragma once

#include <array>
#include <cstddef>

#include "core/base/symmetric_tensor.hpp"
#include "core/fem/element_geometry.hpp"
#include "core/mechanics/point_block.hpp"

namespace dccast::mechanics {

/// Common part of the forms of every element: nodal vectors and the mean dilatation, which
/// determines the pressure.
/// @tparam Number  double, or Lanes for several elements at once
template <class Element, class Number>
struct ElementFormsBase {
  static constexpr std::size_t nodes = Element::nodes, points = Element::points,
                               dim = Element::dimension, unknowns = nodes * dim;
  using Cell = fem::ElementCell<Element, Number>;
  using Tensor = SymmetricTensor<Element::dimension, Number>;
  using Vectors = std::array<std::array<Number, dim>, nodes>;
  using Tensors = std::array<Tensor, points>;
  using Responses = std::array<PointResponse<Element::dimension, Number>, points>;
  using Pressures = std::array<Number, points>;
  using Matrix = std::array<Number, unknowns * unknowns>;  ///< its lower triangle, row by row

  static Number mean_dilatation(const typename Cell::Gradients& mean, const Vectors& v) {
    Number sum{};
    for (std::size_t i = 0; i < nodes; ++i) {
      for (std::size_t a = 0; a < dim; ++a) sum += mean[i][a] * v[i][a];
    }
    return sum;
  }
  static Number mean_dilatation(const Cell& c, const Vectors& v) {
    return mean_dilatation(c.mean_gradient, v);
  }
};

/// The forms of one element: strains of a displacement, forces of a stress, stiffness of a tangent.
///
/// The volumetric part uses the mean dilatation of the element (for linear triangles the gradient
/// itself), the deviatoric part the gradient at each point. The same code serves P1 and B-bar
/// elements in 2D and 3D.
template <class Element, class Number = double, bool = fem::has_bending_modes<Element>>
struct ElementForms : ElementFormsBase<Element, Number> {
  using Base = ElementFormsBase<Element, Number>;
  using Base::dim, Base::nodes, Base::points, Base::unknowns;
  using typename Base::Cell, typename Base::Matrix, typename Base::Pressures,
      typename Base::Responses, typename Base::Tensor, typename Base::Tensors,
      typename Base::Vectors;
  static constexpr bool axisymmetric = fem::is_axisymmetric<Element>;
  static constexpr std::size_t hoop = 2;  ///< component zz of a tensor
  using Point = typename Cell::Point;

  /// Strain at a point, with its trace replaced by the mean dilatation of the element.
  static Tensor strain(const Cell& c, std::size_t q, const Vectors& v) {
    Tensor strain = symmetric_gradient(c.point[q], v);
    if constexpr (points > 1) {
      strain.add_identity((Base::mean_dilatation(c, v) - strain.trace()) / 3.0);
    }
    return strain;
  }

  /// Deviator of the strain at every point.
  static Tensors strain_deviators(const Cell& c, const Vectors& v) {
    Tensors deviators;
    for (std::size_t q = 0; q < points; ++q) {
      deviators[q] = symmetric_gradient(c.point[q], v).deviator();
    }
    return deviators;
  }

  /// Nodal forces of stress deviators and mean normal stresses.
  static Vectors forces(const Cell& c, const Tensors& deviator, const Pressures& pressure) {
    Vectors force{};
    for (std::size_t q = 0; q < points; ++q) {
      const Point& point = c.point[q];
      const Tensor& s = deviator[q];
      for (std::size_t i = 0; i < nodes; ++i) {
        for (std::size_t a = 0; a < dim; ++a) {
          Number f = pressure[q] * c.mean_gradient[i][a];
          for (std::size_t b = 0; b < dim; ++b) f += s.at(a, b) * point.gradient[i][b];
          if constexpr (axisymmetric) {
            if (a == 0) f += s[hoop] * point.hoop[i];
          }
          force[i][a] += point.weight * f;
        }
      }
    }
    return force;
  }

  /// Stiffness from the responses at the points and a bulk modulus.
  static Matrix stiffness(const Cell& c, const Responses& response, const Number& bulk_modulus) {
    Matrix k{};
    for (std::size_t q = 0; q < points; ++q) {
      const auto& g = c.point[q].gradient;
      const auto& r = response[q];
      const Number weight = c.point[q].weight, mu = weight * r.shear;
      const Number bulk = weight * bulk_modulus;
      const Number softening = weight * r.softening;
      Vectors along{};  // s applied to each gradient
      for (std::size_t i = 0; i < nodes; ++i) {
        for (std::size_t a = 0; a < dim; ++a) {
          for (std::size_t b = 0; b < dim; ++b) along[i][a] += r.deviator.at(a, b) * g[i][b];
        }
      }
      if constexpr (axisymmetric) {
        for (std::size_t i = 0; i < nodes; ++i)
          along[i][0] += r.deviator[hoop] * c.point[q].hoop[i];
      }
      const auto& dilates = dilatation_gradient(c.point[q]);
      for (std::size_t i = 0; i < nodes; ++i) {
        for (std::size_t j = 0; j <= i; ++j) {
          Number dot{};
          for (std::size_t a = 0; a < dim; ++a) dot += g[i][a] * g[j][a];
          for (std::size_t a = 0; a < dim; ++a) {
            Number* row = &k[(i * dim + a) * unknowns + j * dim];
            for (std::size_t b = 0; b < dim; ++b) {
              row[b] += mu * (g[i][b] * g[j][a] - 2.0 / 3.0 * dilates[i][a] * dilates[j][b]) +
                        bulk * c.mean_gradient[i][a] * c.mean_gradient[j][b] +
                        softening * along[i][a] * along[j][b];
            }
            row[a] += mu * dot;
          }
          if constexpr (axisymmetric) {
            k[i * dim * unknowns + j * dim] += 2.0 * mu * c.point[q].hoop[i] * c.point[q].hoop[j];
          }
        }
      }
    }
    return k;
  }

private:
  /// Symmetric gradient, trace not corrected.
  static Tensor symmetric_gradient(const Point& point, const Vectors& v) {
    Tensor strain;
    for (std::size_t i = 0; i < nodes; ++i) {
      for (std::size_t a = 0; a < dim; ++a) {
        strain[a] += point.gradient[i][a] * v[i][a];
        for (std::size_t b = a + 1; b < dim; ++b) {
          strain[Tensor::index(a, b)] +=
              0.5 * (point.gradient[i][a] * v[i][b] + point.gradient[i][b] * v[i][a]);
        }
      }
      if constexpr (axisymmetric) strain[hoop] += point.hoop[i] * v[i][0];
    }
    return strain;
  }

  /// Derivative of the dilatation at a point by the nodal displacements: the gradient, plus the
  /// hoop term in the radial direction if axisymmetric.
  static decltype(auto) dilatation_gradient(const Point& point) {
    if constexpr (axisymmetric) {
      typename Cell::Gradients g = point.gradient;
      for (std::size_t i = 0; i < nodes; ++i) g[i][0] += point.hoop[i];
      return g;
    } else {
      return (point.gradient);
    }
  }
};

}  // namespace dccast::mechanics
