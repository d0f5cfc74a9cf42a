#pragma once

#include <algorithm>

#include "core/mechanics/constitutive.hpp"
#include "tests/unit/mechanics/bodies.hpp"

namespace dccast::mechanics::testing {

/// Half of a block, of a solid a quarter, under its weight on a rigid floor, flat unless it is
/// shaped, its top shrunk so that the ends lift.
template <class Element>
class RestingBlock {
public:
  static constexpr int dimension = Element::dimension;
  static constexpr double height = 0.25;

  /// @param heaviness  weight by volume [N/m3]
  explicit RestingBlock(double shrinkage, double kappa = 0.0, double heaviness = 2.5e4)
      : body(shape()) {
    body.set_material(1e9, 0.35, kappa);
    body.set_contact();
    const std::vector<double> by_element(body.forms.elements(), heaviness);
    body.problem.weight = body.forms.subtract_weight(by_element, body.problem.external_force);
    hold_symmetry(body);
    for (int e = 0; e < body.mesh.elements(); ++e) {
      body.problem.thermal[std::size_t(e)] = -shrinkage * height_of(body.mesh, e) / height;
    }
  }

  StepUnknowns<dimension> at_rest(std::vector<char> contact) const {
    StepUnknowns<dimension> unknowns = body.unknowns();
    unknowns.contact = std::move(contact);
    return unknowns;
  }
  StepUnknowns<dimension> at_rest() const { return body.unknowns(); }
  std::size_t pairs() const { return body.problem.contact.size(); }

  /// Distance of a pair from the planes of symmetry or the axis [m].
  double distance(std::size_t pair) const {
    const auto x = body.place(body.problem.contact[pair] / dimension);
    return dimension == 2 ? x[0] : std::hypot(x[0], x[1]);
  }
  /// The pair nearest to the planes of symmetry, and the one furthest from them.
  std::pair<std::size_t, std::size_t> ends() const {
    std::pair<std::size_t, std::size_t> found{0, 0};
    for (std::size_t i = 0; i < pairs(); ++i) {
      if (distance(i) < distance(found.first)) found.first = i;
      if (distance(i) > distance(found.second)) found.second = i;
    }
    return found;
  }
  /// Lowers the floor by a depth at each distance.
  template <class Depth>
  void shape_floor(Depth&& depth) {
    for (std::size_t i = 0; i < pairs(); ++i) {
      body.problem.initial_gap.push_back(depth(distance(i)));
    }
  }

  /// Gap and reaction of every pair, the reaction from the balance of forces.
  struct Floor {
    std::vector<double> gap, reaction;
    double total = 0.0;
  };
  Floor floor(const StepUnknowns<dimension>& unknowns) const {
    const auto r = body.residual(unknowns.displacement);
    Floor result;
    for (std::size_t i = 0; i < pairs(); ++i) {
      result.gap.push_back(body.problem.normal_gap(i, unknowns.displacement));
      result.reaction.push_back(r[std::size_t(body.problem.contact[i])]);
      result.total += result.reaction.back();
    }
    return result;
  }

  FixedBody<Element> body;

private:
  static mesh::Mesh<dimension> shape() {
    if constexpr (dimension == 2) {
      return box<Element>({1.0, height}, {12, 4});
    } else {
      return box<Element>({1.0, 0.6, height}, {5, 3, 2});
    }
  }
};

}  // namespace dccast::mechanics::testing
