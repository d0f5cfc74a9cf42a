#pragma once

#include <functional>
#include <utility>

#include "core/mechanics/constitutive.hpp"
#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/forms_of.hpp"
#include "core/mechanics/solve_step.hpp"
#include "tests/support/usual_options.hpp"
#include "tests/unit/mechanics_solid/box_mesh.hpp"

namespace dccast::mechanics::testing {

template <class Element>
inline constexpr bool of_tetrahedra = Element::nodes == 4;

inline Options in_balance(double tolerance = 1e-13) {
  return dccast::testing::usual_options(tolerance);
}

/// A solid of fixed shape and constant elastic and creep data, stepped through time.
template <class Element>
class SolidBody {
public:
  using Tensor = SymmetricTensor<3>;

  explicit SolidBody(BoxMesh shape) : box(std::move(shape)) {
    forms.update(box.mesh);
    std::vector<int> unknown;
    for (int n : box.mesh.element_node) {
      for (int d = 0; d < 3; ++d) unknown.push_back(3 * n + d);
    }
    pattern = linalg::SparsityPattern(3 * box.mesh.nodes(), unknown, 3 * Element::nodes);
    work.resize(pattern, linalg::Geometry::solid);
    const std::size_t elements = std::size_t(box.mesh.elements());
    problem.forms = &forms;
    problem.pattern = &pattern;
    for (auto* field :
         {&problem.bulk, &problem.shear, &problem.kappa, &problem.thermal, &problem.prestress}) {
      field->assign(elements, 0.0);
    }
    problem.inelastic.resize(elements * Element::points);
    const std::size_t unknowns = 3 * std::size_t(box.mesh.nodes());
    problem.external_force.assign(unknowns, 0.0);
    problem.fixed.assign(unknowns, 0);
    problem.target.assign(unknowns, 0.0);
    unknowns_.displacement.assign(unknowns, 0.0);
    unknowns_.deviator.resize(elements * Element::points);
    problem.dt = 1.0;
  }
  SolidBody(const SolidBody&) = delete;

  /// Young's modulus [Pa], Poisson's ratio and creep factor of all elements.
  void set_material(double young, double poisson, double kappa = 0.0, double exponent = 6.0) {
    std::fill(problem.bulk.begin(), problem.bulk.end(), young / (3.0 * (1.0 - 2.0 * poisson)));
    std::fill(problem.shear.begin(), problem.shear.end(), young / (2.0 * (1.0 + poisson)));
    std::fill(problem.kappa.begin(), problem.kappa.end(), kappa);
    problem.exponent = exponent;
  }

  void fix(int node, int direction, double target) {
    problem.fixed[std::size_t(3 * node + direction)] = 1;
    problem.target[std::size_t(3 * node + direction)] = target;
  }
  void fix(int node, const Vector3& target) {
    for (int d = 0; d < 3; ++d) fix(node, d, target[std::size_t(d)]);
  }
  template <class Displacement>
  void hold_boundary(Displacement&& displacement) {
    for (int n = 0; n < box.mesh.nodes(); ++n) {
      if (box.on_boundary(n)) fix(n, displacement(place(n)));
    }
  }

  /// Makes the vertical unknowns of the lower face contact unknowns, all closed at first.
  void set_contact() {
    const auto nodes = box.nodes_on(Face::z_low);
    std::vector<double> share(std::size_t(box.mesh.nodes()), 0.0);
    for (const auto& facet : box.facets(Face::z_low)) {
      const auto shares = forms.facet_shares(facet);
      for (std::size_t i = 0; i < std::size_t(facet.nodes); ++i) {
        share[std::size_t(facet.node[i])] += shares[i];
      }
    }
    for (int n : nodes) {
      problem.contact.push_back(3 * n + 2);
      problem.contact_area.push_back(share[std::size_t(n)]);
    }
    unknowns_.contact.assign(nodes.size(), 1);
  }

  /// Adds the nodal forces of a traction on a face whose facets are plane: it is interpolated from
  /// the nodes of each facet, exact of a linear traction.
  void add_traction(Face face, const std::function<Vector3(const Vector3&)>& traction) {
    for (const auto& facet : box.facets(face)) add_traction(facet, traction);
  }

  StepOutcome step(const Options& options, double dt = 1.0) {
    problem.dt = dt;
    auto trial = unknowns_;
    const auto outcome = solve_step(problem, options, work, trial);
    if (outcome.converged) {
      unknowns_ = std::move(trial);
      accumulate_viscoplastic_strain(problem, unknowns_.deviator, unknowns_.displacement,
                                     problem.hardened, problem.inelastic);
    }
    return outcome;
  }

  Vector3 place(int n) const {
    const double* x = box.mesh.point(n);
    return {x[0], x[1], x[2]};
  }
  double displacement(int node, int direction) const {
    return unknowns_.displacement[std::size_t(3 * node + direction)];
  }
  const std::vector<double>& displacement() const { return unknowns_.displacement; }
  const StepUnknowns<3>& unknowns() const { return unknowns_; }

  /// At every point [Pa], of the last step's end.
  std::vector<Tensor> stresses() const {
    std::vector<Tensor> all = unknowns_.deviator;
    for (std::size_t i = 0; i < all.size(); ++i) {
      all[i].add_identity(mean_normal_stress(problem, static_cast<int>(i / Element::points),
                                             unknowns_.displacement));
    }
    return all;
  }
  /// Internal less external forces at a displacement.
  std::vector<double> residual(const std::vector<double>& u) const {
    std::vector<double> r(u.size());
    Equilibrium equilibrium(problem);
    equilibrium.residual(u, r, return_map_law(problem));
    return r;
  }

  BoxMesh box;
  FormsOf<Element> forms;
  linalg::SparsityPattern pattern;
  Workspace work;
  StepProblem<3> problem;

private:
  void add_traction(const mesh::Facet<3>& facet,
                    const std::function<Vector3(const Vector3&)>& traction) {
    const bool quadrilateral = facet.nodes == 4;

    // Adds a point's share of the traction, by the shape functions there.
    const auto add = [&](const auto& shape, double area) {
      Vector3 at{};
      for (std::size_t i = 0; i < shape.size(); ++i) {
        for (std::size_t d = 0; d < 3; ++d) at[d] += shape[i] * place(facet.node[i])[d];
      }
      const Vector3 t = traction(at);
      for (std::size_t i = 0; i < shape.size(); ++i) {
        for (std::size_t d = 0; d < 3; ++d) {
          problem.external_force[std::size_t(3 * facet.node[i]) + d] += shape[i] * area * t[d];
        }
      }
    };

    // A triangle by the middles of its edges, exact up to quadratic terms.
    if (!quadrilateral) {
      const double third = fem::facet_shares(box.mesh, facet)[0];
      for (std::size_t edge = 0; edge < 3; ++edge) {
        std::array<double, 3> shape{0.5, 0.5, 0.5};
        shape[edge] = 0.0;
        add(shape, third);
      }
      return;
    }

    // A quadrilateral by 2 x 2 Gauss points.
    for (const auto& p : fem::Q1Quadrilateral::point) {
      const auto gradient = fem::Q1Quadrilateral::shape_gradient(p);
      Eigen::Vector3d along = Eigen::Vector3d::Zero(), across = along;
      for (std::size_t i = 0; i < 4; ++i) {
        const Eigen::Map<const Eigen::Vector3d> x(box.mesh.point(facet.node[i]));
        along += gradient[i][0] * x;
        across += gradient[i][1] * x;
      }
      add(fem::Q1Quadrilateral::shape(p), along.cross(across).norm());
    }
  }

  StepUnknowns<3> unknowns_;
};

}  // namespace dccast::mechanics::testing
