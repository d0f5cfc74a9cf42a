#pragma once

#include "core/mechanics/constitutive.hpp"
#include "tests/unit/mechanics/bodies.hpp"

namespace dccast::mechanics::testing {

/// Half of a block under its weight on a rigid floor, flat unless it is shaped, its top shrunk so
/// that the ends lift.
template <class Element>
class RestingBlock {
public:
  /// @param heaviness  weight by volume [N/m3]
  explicit RestingBlock(double shrinkage, double kappa = 0.0, double heaviness = 2.5e4)
      : body(verification::uniform_rectangle(1.0, 0.25, 12, 4, kind_of<Element>)) {
    body.set_material(1e9, 0.35, kappa, 6.0);
    body.set_contact();
    body.add_body_force([=](double, double) { return Vector2{0.0, -heaviness}; });
    body.problem.weight = heaviness * 0.25;
    for (int n = 0; n < body.mesh.nodes(); ++n) {
      if (body.mesh.point(n)[0] == 0.0) body.fix(n, 0, 0.0);
    }
    for (int e = 0; e < body.mesh.elements(); ++e) {
      double y = 0.0;
      for (int i = 0; i < Element::nodes; ++i) {
        y += body.mesh.point(body.mesh.nodes_of(e)[i])[1] / Element::nodes;
      }
      body.problem.thermal[std::size_t(e)] = -shrinkage * y / 0.25;
    }
    body.problem.dt = 1.0;
  }

  StepUnknowns<2> at_rest(std::vector<char> contact) const {
    StepUnknowns<2> unknowns;
    unknowns.displacement.assign(body.problem.unknowns(), 0.0);
    unknowns.deviator.resize(body.problem.inelastic.size());
    unknowns.contact = std::move(contact);
    return unknowns;
  }
  std::size_t pairs() const { return body.problem.contact.size(); }

  /// Lowers the floor by a depth at each distance from the symmetry plane.
  template <class Depth>
  void shape_floor(Depth&& depth) {
    for (int unknown : body.problem.contact) {
      body.problem.initial_gap.push_back(depth(body.mesh.point(unknown / 2)[0]));
    }
  }

  /// Gap and reaction of every pair, the reaction from the balance of forces.
  struct Floor {
    std::vector<double> gap, reaction;
    double total = 0.0;
  };
  Floor floor(const StepUnknowns<2>& unknowns) const {
    Equilibrium equilibrium(body.problem);
    std::vector<double> r(body.problem.unknowns());
    equilibrium.residual(unknowns.displacement, r, return_map_law(body.problem));
    Floor result;
    for (std::size_t i = 0; i < pairs(); ++i) {
      result.gap.push_back(body.problem.normal_gap(i, unknowns.displacement));
      result.reaction.push_back(r[std::size_t(body.problem.contact[i])]);
      result.total += result.reaction.back();
    }
    return result;
  }

  FixedBody<Element> body;
};

}  // namespace dccast::mechanics::testing
