#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/mechanics/constitutive.hpp"
#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/forms_of.hpp"
#include "core/mechanics/solve_step.hpp"
#include "core/mesh/slab_mesh.hpp"
#include "tests/verification/mechanics/figures.hpp"

namespace dccast::verification {

template <int Dim>
using Vector = std::array<double, std::size_t(Dim)>;
using Vector2 = Vector<2>;
using Vector3 = Vector<3>;
/// Stress of a plane problem: 22, 33, 11 (out of plane), 23 in the paper's numbers.
using PlaneStress = SymmetricTensor<2>;

/// A function of the coordinates [m].
template <class Value, int Dim>
using Field = std::conditional_t<Dim == 2, std::function<Value(double, double)>,
                                 std::function<Value(double, double, double)>>;

/// A body of fixed shape and constant elastic and creep data, stepped through time: what the
/// paper's tests T1 to T4 need of the mechanics, without a casting around it. Axisymmetric forces
/// are per radian.
template <class Element>
class FixedBody {
public:
  static constexpr int dimension = Element::dimension;
  static constexpr std::size_t dim = dimension;
  using Place = Vector<dimension>;
  using Tensor = SymmetricTensor<dimension>;
  using VectorField = Field<Place, dimension>;

  explicit FixedBody(mesh::Mesh<dimension> body) : mesh(std::move(body)) {
    forms.update(mesh);
    std::vector<int> unknown;
    for (int n : mesh.element_node) {
      for (int d = 0; d < dimension; ++d) unknown.push_back(dimension * n + d);
    }
    pattern =
        linalg::SparsityPattern(dimension * mesh.nodes(), unknown, dimension * Element::nodes);
    work.resize(pattern, dimension == 2 ? linalg::Geometry::plane : linalg::Geometry::solid);

    const std::size_t elements = std::size_t(mesh.elements()),
                      unknowns = dim * std::size_t(mesh.nodes());
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
    problem.dt = 1.0;

    unknowns_.displacement.assign(unknowns, 0.0);
    unknowns_.deviator.resize(elements * Element::points);
    mean_stress_.assign(elements, 0.0);
  }
  FixedBody(const FixedBody&) = delete;

  /// Young's modulus [Pa], Poisson's ratio and creep factor of all elements.
  void set_material(double young, double poisson, double kappa = 0.0, double exponent = 6.0) {
    std::fill(problem.bulk.begin(), problem.bulk.end(), young / (3.0 * (1.0 - 2.0 * poisson)));
    std::fill(problem.shear.begin(), problem.shear.end(), young / (2.0 * (1.0 + poisson)));
    std::fill(problem.kappa.begin(), problem.kappa.end(), kappa);
    problem.exponent = exponent;
  }

  /// Makes the bottom's vertical unknowns contact unknowns, all closed at first.
  void set_contact() {
    std::vector<double> share(std::size_t(mesh.nodes()), 0.0);
    mesh::for_each_facet(mesh, mesh::PatchKind::bottom, [&](const auto& facet, const auto&) {
      const auto shares = forms.facet_shares(facet);
      for (std::size_t i = 0; i < std::size_t(facet.nodes); ++i) {
        share[std::size_t(facet.node[i])] += shares[i];
      }
    });
    for (int n : mesh::patch_nodes(mesh, mesh::PatchKind::bottom)) {
      problem.contact.push_back(dimension * n + dimension - 1);
      problem.contact_area.push_back(share[std::size_t(n)]);
    }
    set_closed_contact();
  }
  /// Starts from all contact unknowns closed.
  void set_closed_contact() { unknowns_.contact.assign(problem.contact.size(), 1); }

  void fix(int node, int direction, double target) {
    problem.fixed[std::size_t(dimension * node + direction)] = 1;
    problem.target[std::size_t(dimension * node + direction)] = target;
  }
  void fix(int node, const Place& target) {
    for (int d = 0; d < dimension; ++d) fix(node, d, target[std::size_t(d)]);
  }

  /// Adds the nodal forces of a traction on all patches of a kind, or on one.
  void add_traction(mesh::PatchKind kind, const VectorField& traction) {
    mesh::for_each_facet(mesh, kind,
                         [&](const auto& facet, const auto&) { add_traction(facet, traction); });
  }
  void add_traction(const mesh::Patch<dimension>& patch, const VectorField& traction) {
    for (const auto& facet : patch.facets) add_traction(facet, traction);
  }

  /// Adds the nodal forces of a body force on a section.
  void add_body_force(const VectorField& force);

  void clear_forces() {
    std::fill(problem.external_force.begin(), problem.external_force.end(), 0.0);
  }

  mechanics::StepOutcome step(const mechanics::Options& options, double dt = 1.0) {
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
  double displacement(int node, int direction) const {
    return unknowns_.displacement[std::size_t(dimension * node + direction)];
  }
  const mechanics::StepUnknowns<dimension>& unknowns() const { return unknowns_; }

  /// Coordinates of a node [m].
  Place place(int node) const {
    Place x;
    std::copy_n(mesh.point(node), dim, x.begin());
    return x;
  }
  /// The node nearest to a place.
  int node_at(const Place& place) const {
    const auto distance = [&](int n) {
      double sum = 0.0;
      for (std::size_t d = 0; d < dim; ++d)
        sum += (mesh.point(n)[d] - place[d]) * (mesh.point(n)[d] - place[d]);
      return sum;
    };
    int nearest = 0;
    for (int n = 1; n < mesh.nodes(); ++n)
      if (distance(n) < distance(nearest)) nearest = n;
    return nearest;
  }

  /// Internal less external forces at a displacement.
  std::vector<double> residual(const std::vector<double>& u) const {
    std::vector<double> r(u.size());
    mechanics::Equilibrium equilibrium(problem);
    equilibrium.residual(u, r, mechanics::return_map_law(problem));
    return r;
  }

  /// Factor of an integral over the section at a distance `x` from the axis: x if axisymmetric [m].
  static double radius_factor(double x) { return fem::is_axisymmetric<Element> ? x : 1.0; }

  /// Stress at a quadrature point [Pa], of the last step's end.
  Tensor stress(int element, std::size_t point) const {
    Tensor s = unknowns_.deviator[std::size_t(element) * Element::points + point];
    return s.add_identity(mean_stress_[std::size_t(element)]);
  }
  std::vector<Tensor> stresses() const {
    std::vector<Tensor> all = unknowns_.deviator;
    for (std::size_t i = 0; i < all.size(); ++i) {
      all[i].add_identity(mean_stress_[i / Element::points]);
    }
    return all;
  }

  mesh::Mesh<dimension> mesh;
  mechanics::FormsOf<Element> forms;
  linalg::SparsityPattern pattern;
  mechanics::Workspace work;
  mechanics::StepProblem<dimension> problem;

private:
  /// Adds a force at a point of a facet to its nodes, by the shape functions there.
  template <std::size_t Nodes>
  void add_force(const mesh::Facet<dimension>& facet, const std::array<double, Nodes>& shape,
                 const Place& force) {
    for (std::size_t i = 0; i < Nodes; ++i) {
      for (std::size_t d = 0; d < dim; ++d) {
        problem.external_force[dim * std::size_t(facet.node[i]) + d] += shape[i] * force[d];
      }
    }
  }

  /// An edge by three Gauss points, a plane facet of a solid exactly for a linear traction.
  void add_traction(const mesh::Facet<dimension>& facet, const VectorField& traction) {
    // Adds the share of a point, by the shape functions and the area that belongs to it.
    const auto add = [&](const auto& shape, double area) {
      Place at{};
      for (std::size_t i = 0; i < shape.size(); ++i) {
        for (std::size_t d = 0; d < dim; ++d) at[d] += shape[i] * mesh.point(facet.node[i])[d];
      }
      Place force = std::apply(traction, at);
      for (double& component : force) component *= area * radius_factor(at[0]);
      add_force(facet, shape, force);
    };

    if constexpr (dimension == 2) {
      constexpr double at[3] = {0.11270166537925831, 0.5, 0.88729833462074169};
      constexpr double weight[3] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
      const double *a = mesh.point(facet.node[0]), *b = mesh.point(facet.node[1]);
      const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
      for (int k = 0; k < 3; ++k) add(std::array{1.0 - at[k], at[k]}, weight[k] * length);
    } else if (facet.nodes == 3) {
      // The middles of the edges, exact up to quadratic terms.
      const double third = fem::facet_shares(mesh, facet)[0];
      for (std::size_t edge = 0; edge < 3; ++edge) {
        std::array<double, 3> shape{0.5, 0.5, 0.5};
        shape[edge] = 0.0;
        add(shape, third);
      }
    } else {
      for (const auto& p : fem::Q1Quadrilateral::point) {
        const auto gradient = fem::Q1Quadrilateral::shape_gradient(p);
        Eigen::Vector3d along = Eigen::Vector3d::Zero(), across = along;
        for (std::size_t i = 0; i < 4; ++i) {
          const Eigen::Map<const Eigen::Vector3d> x(mesh.point(facet.node[i]));
          along += gradient[i][0] * x;
          across += gradient[i][1] * x;
        }
        add(fem::Q1Quadrilateral::shape(p), along.cross(across).norm());
      }
    }
  }

  /// Before the creep of the step joins the inelastic strain, from which it follows.
  void store_mean_stress() {
    for (int e = 0; e < mesh.elements(); ++e) {
      mean_stress_[std::size_t(e)] =
          mechanics::mean_normal_stress(problem, e, unknowns_.displacement);
    }
  }

  mechanics::StepUnknowns<dimension> unknowns_;
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
