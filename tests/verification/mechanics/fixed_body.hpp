#pragma once

#include <array>
#include <functional>
#include <numeric>
#include <stdexcept>
#include <string>

#include "core/mechanics/constitutive.hpp"
#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/forms_of.hpp"
#include "core/mechanics/solve_step.hpp"
#include "core/mesh/slab_mesh.hpp"
#include "tests/verification/mechanics/figures.hpp"

namespace dccast::verification {

using Vector2 = std::array<double, 2>;
/// Stress of a plane problem: 22, 33, 11 (out of plane), 23 in the paper's numbers.
using PlaneStress = SymmetricTensor<2>;

/// A body of fixed shape and constant elastic and creep data, stepped through time: what the
/// paper's tests T1 to T4 need of the mechanics, without a casting around it. Axisymmetric forces
/// are per radian.
template <class Element>
class FixedBody {
public:
  explicit FixedBody(mesh::Mesh2D body) : mesh(std::move(body)) {
    forms.update(mesh);
    std::vector<int> unknown;
    for (int n : mesh.element_node) {
      unknown.push_back(2 * n);
      unknown.push_back(2 * n + 1);
    }
    pattern = linalg::SparsityPattern(2 * mesh.nodes(), unknown, 2 * Element::nodes);
    work.resize(pattern, linalg::Geometry::plane);
    const std::size_t elements = std::size_t(mesh.elements()),
                      unknowns = 2 * std::size_t(mesh.nodes());
    problem.forms = &forms;
    problem.pattern = &pattern;
    for (auto* field :
         {&problem.bulk, &problem.shear, &problem.kappa, &problem.thermal, &problem.prestress}) {
      field->assign(elements, 0.0);
    }
    problem.inelastic.resize(elements * Element::points);
    problem.external_force.assign(unknowns, 0.0);
    problem.fixed.assign(unknowns, 0);
    problem.target.assign(unknowns, 0.0);
    unknowns_.displacement.assign(unknowns, 0.0);
    unknowns_.deviator.resize(elements * Element::points);
    mean_stress_.assign(elements, 0.0);
  }
  FixedBody(const FixedBody&) = delete;

  /// Young's modulus [Pa], Poisson's ratio and creep factor of all elements.
  void set_material(double young, double poisson, double kappa, double exponent) {
    std::fill(problem.bulk.begin(), problem.bulk.end(), young / (3.0 * (1.0 - 2.0 * poisson)));
    std::fill(problem.shear.begin(), problem.shear.end(), young / (2.0 * (1.0 + poisson)));
    std::fill(problem.kappa.begin(), problem.kappa.end(), kappa);
    problem.exponent = exponent;
  }

  /// Makes the bottom's vertical unknowns contact unknowns, all closed at first.
  void set_contact() {
    for (int n : mesh::patch_nodes(mesh, mesh::PatchKind::bottom)) {
      problem.contact.push_back(2 * n + 1);
      problem.contact_area.push_back(0.0);
    }
    for (const auto& facet : mesh.facets(mesh::PatchKind::bottom)) {
      const auto area = fem::facet_shares_of<Element>(mesh, facet);
      for (std::size_t k = 0; k < area.size(); ++k) {
        for (std::size_t i = 0; i < problem.contact.size(); ++i) {
          if (problem.contact[i] == 2 * facet.node[k] + 1) problem.contact_area[i] += area[k];
        }
      }
    }
    set_closed_contact();
  }
  /// Starts from all contact unknowns closed.
  void set_closed_contact() { unknowns_.contact.assign(problem.contact.size(), 1); }

  void fix(int node, int direction, double target) {
    problem.fixed[std::size_t(2 * node + direction)] = 1;
    problem.target[std::size_t(2 * node + direction)] = target;
  }

  /// Adds the nodal forces of a traction on a patch, by three Gauss points an edge.
  void add_traction(mesh::PatchKind patch, const std::function<Vector2(double, double)>& traction) {
    constexpr double at[3] = {0.11270166537925831, 0.5, 0.88729833462074169};
    constexpr double weight[3] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
    for (const auto& facet : mesh.facets(patch)) {
      const double* a = mesh.point(facet.node[0]);
      const double* b = mesh.point(facet.node[1]);
      const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
      for (int k = 0; k < 3; ++k) {
        const double x = a[0] + at[k] * (b[0] - a[0]);
        const Vector2 t = traction(x, a[1] + at[k] * (b[1] - a[1]));
        for (std::size_t d = 0; d < 2; ++d) {
          const double f = weight[k] * length * radius_factor(x) * t[d];
          problem.external_force[2 * std::size_t(facet.node[0]) + d] += (1.0 - at[k]) * f;
          problem.external_force[2 * std::size_t(facet.node[1]) + d] += at[k] * f;
        }
      }
    }
  }

  /// Adds the nodal forces of a body force.
  void add_body_force(const std::function<Vector2(double, double)>& force);

  void clear_forces() {
    std::fill(problem.external_force.begin(), problem.external_force.end(), 0.0);
  }

  mechanics::StepOutcome step(const mechanics::Options& options, double dt) {
    problem.dt = dt;
    auto trial = unknowns_;
    const auto outcome = mechanics::solve_step(problem, options, work, trial);
    if (outcome.converged) {
      unknowns_ = std::move(trial);
      store_mean_stress();
      mechanics::accumulate_viscoplastic_strain(problem, unknowns_.deviator, unknowns_.displacement,
                                                problem.hardened, problem.inelastic);
    }
    return outcome;
  }

  const std::vector<double>& displacement() const { return unknowns_.displacement; }
  const mechanics::StepUnknowns<2>& unknowns() const { return unknowns_; }

  /// Factor of an integral over the section at a distance `x` from the axis: x if axisymmetric [m].
  static double radius_factor(double x) { return fem::is_axisymmetric<Element> ? x : 1.0; }

  /// Stress at a quadrature point [Pa], of the last step's end.
  PlaneStress stress(int element, std::size_t point) const {
    PlaneStress s = unknowns_.deviator[std::size_t(element) * Element::points + point];
    return s.add_identity(mean_stress_[std::size_t(element)]);
  }
  std::vector<PlaneStress> stresses() const {
    std::vector<PlaneStress> all = unknowns_.deviator;
    for (std::size_t i = 0; i < all.size(); ++i) {
      all[i].add_identity(mean_stress_[i / Element::points]);
    }
    return all;
  }

  mesh::Mesh2D mesh;
  mechanics::FormsOf<Element> forms;
  linalg::SparsityPattern pattern;
  mechanics::Workspace work;
  mechanics::StepProblem<2> problem;

private:
  /// Before the creep of the step joins the inelastic strain, from which it follows.
  void store_mean_stress() {
    for (int e = 0; e < mesh.elements(); ++e) {
      mean_stress_[std::size_t(e)] =
          mechanics::mean_normal_stress(problem, e, unknowns_.displacement);
    }
  }

  mechanics::StepUnknowns<2> unknowns_;
  std::vector<double> mean_stress_;  ///< (element) [Pa] at the end of the last step
};

/// A square or rectangle of equal cells from (0, 0), patches named as for a slab.
mesh::Mesh2D uniform_rectangle(double width, double height, int columns, int rows,
                               mesh::ElementKind kind);

/// Points and weights for integrals of exact fields over an element: 16 sub-triangles of each
/// triangle with three points each, so that a kink inside an element does not matter.
struct IntegrationPoint {
  double x, y, weight;          ///< weight [m2]
  std::array<double, 4> shape;  ///< shape functions of the element there
};
std::vector<IntegrationPoint> integration_points(const mesh::Mesh2D& mesh, int element);

/// Relative L2 errors of displacement and stress against exact fields, by quadrature.
struct Errors {
  double displacement = 0.0;
  double stress = 0.0;
  double stress_at_centroids = 0.0;  ///< exact stress taken at the centroid of each element
};
template <class Element>
Errors relative_errors(const FixedBody<Element>& body,
                       const std::function<Vector2(double, double)>& displacement,
                       const std::function<PlaneStress(double, double)>& stress);

}  // namespace dccast::verification

#include "tests/verification/mechanics/fixed_body_integrals.hpp"
