#pragma once

#include <array>
#include <cstddef>

#include "core/base/tensors.hpp"
#include "core/fem/element_geometry.hpp"
#include "core/mechanics/element_parts.hpp"

namespace dccast::mechanics {

/// Common part of the forms of every element: nodal vectors and the mean dilatation, which
/// determines the pressure.
/// @tparam Number  double, or Lanes for several elements at once
template <class Element, class Number>
struct ElementFormsBase {
  /// Numbers of nodes, integration points, coordinates and nodal displacements of an element.
  static constexpr std::size_t nodes = Element::nodes, points = Element::points,
                               dim = Element::dimension, unknowns = nodes * dim;
  using Cell = fem::ElementCell<Element, Number>;
  using Tensor = SymmetricTensor<Element::dimension, Number>;
  /// (node, direction) displacements [m], or forces [N/m] in 2D, [N/rad] if axisymmetric, [N] in
  /// 3D.
  using Vectors = std::array<std::array<Number, dim>, nodes>;
  /// (point) strains [1] or stresses [Pa].
  using Tensors = std::array<Tensor, points>;
  using Responses = std::array<PointResponse<Element::dimension, Number>, points>;
  /// (point) mean normal stresses [Pa].
  using Pressures = std::array<Number, points>;
  using Matrix = std::array<Number, unknowns * unknowns>;  ///< its lower triangle, row by row

  /// Mean of div v over the element [1]: sum of the products of mean gradient and displacement.
  /// @param mean  (node, direction) mean gradients of the shape functions [1/m]
  /// @param v     displacements [m]
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

  /// Strain at every point [1], with its trace replaced by the mean dilatation of the element.
  static Tensors strains(const Cell& c, const Vectors& v) {
    const Number dilatation = Base::mean_dilatation(c, v);
    Tensors strains;
    for (std::size_t q = 0; q < points; ++q) {
      strains[q] = symmetric_gradient(c.point[q], v);
      if constexpr (points > 1) strains[q].add_identity((dilatation - strains[q].trace()) / 3.0);
    }
    return strains;
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
          // The volume uses the mean gradient (B-bar), the deviator the gradient at the point.
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

      // The deviator s applied to each gradient: the direction in which the law softens.
      Vectors along{};
      for (std::size_t i = 0; i < nodes; ++i) {
        for (std::size_t a = 0; a < dim; ++a) {
          for (std::size_t b = 0; b < dim; ++b) along[i][a] += r.deviator.at(a, b) * g[i][b];
        }
      }
      if constexpr (axisymmetric) {
        for (std::size_t i = 0; i < nodes; ++i)
          along[i][0] += r.deviator[hoop] * c.point[q].hoop[i];
      }

      // K = 2 mu~ (sym grad)^T (sym grad), less its trace, plus bulk and softening: lower triangle.
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

/// The forms of an element whose strain is its mean and bending modes (fem::BendingQuadrilateral).
/// The modes preserve the volume, so that the mean dilatation holds at every point.
template <class Element, class Number>
struct ElementForms<Element, Number, true> : ElementFormsBase<Element, Number> {
  using Base = ElementFormsBase<Element, Number>;
  using Base::dim, Base::nodes, Base::points, Base::unknowns;
  using typename Base::Cell, typename Base::Matrix, typename Base::Pressures,
      typename Base::Responses, typename Base::Tensor, typename Base::Tensors,
      typename Base::Vectors;
  static constexpr bool axisymmetric = fem::is_axisymmetric<Element>;
  /// Two axes of the section, each with a bending mode; the hoop strain varies likewise.
  static constexpr std::size_t modes = axisymmetric ? 4 : 2;

  /// Strain at every point [1].
  static Tensors strains(const Cell& c, const Vectors& v) {
    Tensors strains = strain_deviators(c, v);
    const Number dilatation = Base::mean_dilatation(c, v);
    for (Tensor& strain : strains) strain.add_identity(dilatation / 3.0);
    return strains;
  }

  /// Strain deviators [1] at every point: that of the mean, and each mode with the lever of its
  /// point.
  static Tensors strain_deviators(const Cell& c, const Vectors& v) {
    Tensor mean;
    Number amplitude[modes] = {};
    for (std::size_t i = 0; i < nodes; ++i) {
      const auto g = section_gradient(c, i);
      mean[0] += g[0] * v[i][0];
      mean[1] += g[1] * v[i][1];
      if constexpr (axisymmetric) mean[2] += c.mean_hoop[i] * v[i][0];
      mean[3] += 0.5 * (g[0] * v[i][1] + g[1] * v[i][0]);
      for (std::size_t m = 0; m < modes; ++m) {
        const auto& share = c.bending[m].amplitude[i];
        amplitude[m] += share[0] * v[i][0] + share[1] * v[i][1];
      }
    }
    Tensors deviators;
    deviators.fill(mean.deviator());
    for (std::size_t q = 0; q < points; ++q) {
      for (std::size_t m = 0; m < modes; ++m) {
        deviators[q].add(lever(c, q, m) * amplitude[m], c.bending[m].strain);
      }
    }
    return deviators;
  }

  /// Nodal forces of stress deviators and mean normal stresses [Pa]: the stress integrated over the
  /// element works on the mean strain, its moments work on the modes.
  static Vectors forces(const Cell& c, const Tensors& deviator, const Pressures& pressure) {
    Tensor sum;  // of the stress deviator over the volume [N/m]
    Number pressures{}, bending[modes] = {};
    for (std::size_t q = 0; q < points; ++q) {
      const Number weight = c.point[q].weight;
      const Tensor& s = deviator[q];
      sum.add(weight, s);
      pressures += weight * pressure[q];
      for (std::size_t m = 0; m < modes; ++m) {
        bending[m] += weight * lever(c, q, m) * contract(s, c.bending[m].strain);
      }
    }
    Vectors force{};
    for (std::size_t i = 0; i < nodes; ++i) {
      const auto g = section_gradient(c, i);
      for (std::size_t a = 0; a < dim; ++a) {
        Number f = sum.at(a, 0) * g[0] + sum.at(a, 1) * g[1] + pressures * c.mean_gradient[i][a];
        for (std::size_t m = 0; m < modes; ++m) f += bending[m] * c.bending[m].amplitude[i][a];
        force[i][a] = f;
      }
      if constexpr (axisymmetric) force[i][0] += sum[2] * c.mean_hoop[i];
    }
    return force;
  }

  /// Stiffness from the responses at the points and the bulk modulus [Pa], lower triangle row by
  /// row.
  static Matrix stiffness(const Cell& c, const Responses& response, const Number& bulk_modulus) {
    Matrix k{};
    const auto mean = mean_deviators_of_unit_displacements(c);
    for (std::size_t q = 0; q < points; ++q) {
      const auto& r = response[q];
      const Number weight = c.point[q].weight, twice_shear = 2.0 * weight * r.shear;
      const Number softening = weight * r.softening;
      std::array<Tensor, unknowns> strain = mean;  // deviators of unit displacements at the point
      std::array<Number, unknowns> along;          // work of the stress on them
      for (std::size_t n = 0; n < unknowns; ++n) {
        for (std::size_t m = 0; m < modes; ++m) {
          strain[n].add(lever(c, q, m) * c.bending[m].amplitude[n / 2][n % 2], c.bending[m].strain);
        }
        along[n] = contract(r.deviator, strain[n]);
      }
      for (std::size_t n = 0; n < unknowns; ++n) {
        const Number bulk = weight * bulk_modulus * c.mean_gradient[n / 2][n % 2];
        for (std::size_t m = 0; m <= n; ++m) {
          k[n * unknowns + m] += twice_shear * contract(strain[n], strain[m]) +
                                 bulk * c.mean_gradient[m / 2][m % 2] +
                                 softening * along[n] * along[m];
        }
      }
    }
    return k;
  }

private:
  /// Double contraction a : b of tensors with the components xx, yy, zz, xy.
  static Number contract(const Tensor& a, const Tensor& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + 2.0 * a[3] * b[3];
  }
  /// Distance of a point from the middle of the element, across the axis of a mode.
  static const Number& lever(const Cell& c, std::size_t q, std::size_t mode) {
    return c.point[q].lever[Cell::lever_of(mode)];
  }

  /// Mean gradient of a shape function in the section, without the hoop.
  static std::array<Number, 2> section_gradient(const Cell& c, std::size_t i) {
    std::array<Number, 2> g = c.mean_gradient[i];
    if constexpr (axisymmetric) g[0] -= c.mean_hoop[i];
    return g;
  }

  /// (unknown) deviators of the mean strain for a unit displacement [1/m].
  static std::array<Tensor, unknowns> mean_deviators_of_unit_displacements(const Cell& c) {
    std::array<Tensor, unknowns> strain;
    for (std::size_t i = 0; i < nodes; ++i) {
      const auto g = section_gradient(c, i);
      Number hoop{}, none{};
      if constexpr (axisymmetric) hoop = c.mean_hoop[i];
      strain[2 * i] = Tensor{{g[0], none, hoop, 0.5 * g[1]}}.deviator();
      strain[2 * i + 1] = Tensor{{none, g[1], none, 0.5 * g[0]}}.deviator();
    }
    return strain;
  }
};

}  // namespace dccast::mechanics
