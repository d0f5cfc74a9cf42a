#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/material/norton_hoff.hpp"
#include "core/material/yosida.hpp"
#include "core/mechanics/step_problem.hpp"

namespace dccast::mechanics {

/// What a material law gives at a point: the stress deviator, and the tangent
/// d s / d e = 2 shear I + normal n (x) n with n = s / |s|.
template <int Dim>
struct PointResponse {
  SymmetricTensor<Dim> deviator;  ///< s [Pa]
  double shear;                   ///< mu~ [Pa]
  double normal;                  ///< [Pa], not positive
  double norm;                    ///< |s| [Pa]
};

/// Internal forces and stiffness of a step problem, over one streaming pass through the elements.
///
/// The volumetric part uses the mean dilatation of the element (for linear triangles that is the
/// gradient itself), so one code serves P1 and B-bar elements of both dimensions.
template <class Element>
class Equilibrium {
public:
  static constexpr int dimension = Element::dimension;
  using Tensor = SymmetricTensor<dimension>;
  using Response = PointResponse<dimension>;

  explicit Equilibrium(const StepProblem<Element>& problem) : problem_(&problem) {
    response_.resize(std::size_t(problem.geometry->elements()) * Element::points);
  }

  /// residual = internal force - external force at displacement `u`; remembers the response of every
  /// point for `tangent`. A law is called as law(element, point, trial strain deviator) -> Response.
  /// @return root of the sum of squares of all element forces: the forces that act, before they
  ///         cancel, against which a residual is small or not
  template <class Law>
  double residual(std::span<const double> u, std::span<double> out, Law&& law) {
    const StepProblem<Element>& p = *problem_;
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = -p.external_force[i];
    double acting = 0.0;
    for (int e = 0; e < p.geometry->elements(); ++e) {
      const auto force = element_force(e, u, law);
      const int* node = p.mesh->nodes_of(e);
      for (std::size_t i = 0; i < nodes; ++i) {
        for (std::size_t a = 0; a < dim; ++a) {
          acting += force[i][a] * force[i][a];
          out[std::size_t(node[i]) * dim + a] += force[i][a];
        }
      }
    }
    return std::sqrt(acting);
  }

  /// Stiffness at the last residual. @param values  the pattern's entries, overwritten
  void tangent(std::span<double> values) const;

  const std::vector<Response>& response() const { return response_; }
  /// Strain of a displacement at a point, its trace replaced by the element's mean dilatation.
  static Tensor strain_of(const typename fem::ElementGeometry<Element>::Cell& cell,
                          std::size_t point, const int* node, std::span<const double> u) {
    return point_strain(cell, cell.point[point], local(node, u));
  }
  /// Mean normal stress of an element at displacement `u` [Pa].
  double pressure(int element, std::span<const double> u) const {
    const Vectors v = local(problem_->mesh->nodes_of(element), u);
    return pressure_of(element, mean_dilatation(cell(element), v), 0);
  }

private:
  static constexpr std::size_t nodes = Element::nodes, points = Element::points,
                               dim = Element::dimension;
  static constexpr bool ring = fem::is_ring<Element>;
  static constexpr std::size_t hoop = 2;  ///< component zz of a tensor
  using Geometry = fem::ElementGeometry<Element>;
  using Vectors = std::array<std::array<double, dim>, nodes>;

  const typename Geometry::Cell& cell(int e) const { return problem_->geometry->cell(e); }

  static Vectors local(const int* node, std::span<const double> u) {
    Vectors v;
    for (std::size_t i = 0; i < nodes; ++i) {
      for (std::size_t a = 0; a < dim; ++a) v[i][a] = u[std::size_t(node[i]) * dim + a];
    }
    return v;
  }

  static double mean_dilatation(const typename Geometry::Cell& c, const Vectors& v) {
    double sum = 0.0;
    for (std::size_t i = 0; i < nodes; ++i) {
      for (std::size_t a = 0; a < dim; ++a) sum += c.mean_gradient[i][a] * v[i][a];
    }
    return sum;
  }

  /// Symmetric gradient without the correction of the trace.
  static Tensor symmetric_gradient(const typename Geometry::Point& point, const Vectors& v) {
    Tensor strain;
    for (std::size_t i = 0; i < nodes; ++i) {
      for (std::size_t a = 0; a < dim; ++a) {
        strain[a] += point.gradient[i][a] * v[i][a];
        for (std::size_t b = a + 1; b < dim; ++b) {
          strain[Tensor::index(a, b)] +=
              0.5 * (point.gradient[i][a] * v[i][b] + point.gradient[i][b] * v[i][a]);
        }
      }
      if constexpr (ring) strain[hoop] += point.hoop[i] * v[i][0];
    }
    return strain;
  }

  /// What a displacement dilates at a point: the gradient, in a ring and across with the hoop.
  static decltype(auto) dilatation_gradient(const typename Geometry::Point& point) {
    if constexpr (ring) {
      typename Geometry::Gradients g = point.gradient;
      for (std::size_t i = 0; i < nodes; ++i) g[i][0] += point.hoop[i];
      return g;
    } else {
      return (point.gradient);
    }
  }

  static Tensor point_strain(const typename Geometry::Cell& c,
                             const typename Geometry::Point& point, const Vectors& v) {
    Tensor strain = symmetric_gradient(point, v);
    if constexpr (points > 1) {
      strain.add_identity((mean_dilatation(c, v) - strain.trace()) / 3.0);
    }
    return strain;
  }

  double pressure_of(int e, double dilatation, std::size_t point) const {
    const StepProblem<Element>& p = *problem_;
    const std::size_t i = std::size_t(e);
    return p.bulk[i] * (dilatation - p.inelastic[i * points + point].trace() - 3.0 * p.thermal[i]) +
           p.prestress[i];
  }

  template <class Law>
  Vectors element_force(int e, std::span<const double> u, Law&& law) {
    const auto& c = cell(e);
    const Vectors v = local(problem_->mesh->nodes_of(e), u);
    const double dilatation = mean_dilatation(c, v);
    Vectors force{};
    for (std::size_t q = 0; q < points; ++q) {
      const auto& point = c.point[q];
      const std::size_t index = std::size_t(e) * points + q;
      Tensor trial = symmetric_gradient(point, v).deviator();
      trial.add(-1.0, problem_->inelastic[index].deviator());
      Response& response = response_[index];
      response = law(std::size_t(e), index, trial);
      const double pressure = pressure_of(e, dilatation, q);
      for (std::size_t i = 0; i < nodes; ++i) {
        for (std::size_t a = 0; a < dim; ++a) {
          double f = pressure * c.mean_gradient[i][a];
          for (std::size_t b = 0; b < dim; ++b) {
            f += response.deviator.at(a, b) * point.gradient[i][b];
          }
          if constexpr (ring) {
            if (a == 0) f += response.deviator[hoop] * point.hoop[i];
          }
          force[i][a] += point.weight * f;
        }
      }
    }
    return force;
  }

  const StepProblem<Element>* problem_;
  std::vector<Response> response_;
};

template <class Element>
void Equilibrium<Element>::tangent(std::span<double> values) const {
  const StepProblem<Element>& p = *problem_;
  std::fill(values.begin(), values.end(), 0.0);
  constexpr std::size_t size = nodes * dim;
  for (int e = 0; e < p.geometry->elements(); ++e) {
    const auto& c = cell(e);
    std::array<double, size * size> k{};
    for (std::size_t q = 0; q < points; ++q) {
      const auto& g = c.point[q].gradient;
      const Response& r = response_[std::size_t(e) * points + q];
      const double weight = c.point[q].weight, mu = weight * r.shear;
      const double bulk = weight * p.bulk[std::size_t(e)];
      const double normal = r.norm > 0.0 ? weight * r.normal / (r.norm * r.norm) : 0.0;
      Vectors along{};  // s applied to each gradient
      for (std::size_t i = 0; i < nodes; ++i) {
        for (std::size_t a = 0; a < dim; ++a) {
          for (std::size_t b = 0; b < dim; ++b) along[i][a] += r.deviator.at(a, b) * g[i][b];
        }
      }
      if constexpr (ring) {
        for (std::size_t i = 0; i < nodes; ++i)
          along[i][0] += r.deviator[hoop] * c.point[q].hoop[i];
      }
      const auto& dilates = dilatation_gradient(c.point[q]);
      for (std::size_t i = 0; i < nodes; ++i) {
        for (std::size_t j = 0; j <= i; ++j) {
          double dot = 0.0;
          for (std::size_t a = 0; a < dim; ++a) dot += g[i][a] * g[j][a];
          for (std::size_t a = 0; a < dim; ++a) {
            double* row = &k[(i * dim + a) * size + j * dim];
            for (std::size_t b = 0; b < dim; ++b) {
              row[b] += mu * (g[i][b] * g[j][a] - 2.0 / 3.0 * dilates[i][a] * dilates[j][b]) +
                        bulk * c.mean_gradient[i][a] * c.mean_gradient[j][b] +
                        normal * along[i][a] * along[j][b];
            }
            row[a] += mu * dot;
          }
          if constexpr (ring) {
            k[i * dim * size + j * dim] += 2.0 * mu * c.point[q].hoop[i] * c.point[q].hoop[j];
          }
        }
      }
    }
    const int* place = p.pattern->places(e);
    for (std::size_t r = 0; r < size; ++r) {
      for (std::size_t s = 0; s <= r; ++s) {
        values[std::size_t(place[r * size + s])] += k[r * size + s];
      }
    }
  }
}

}  // namespace dccast::mechanics
