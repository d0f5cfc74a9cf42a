#include "core/mechanics/front_pressure.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace dccast::mechanics {

namespace {

template <int Dim>
std::vector<char> nodes_of_solid(const mesh::Mesh<Dim>& mesh, const std::vector<char>& solid) {
  std::vector<char> of_solid(std::size_t(mesh.nodes()), 0);
  for (int e = 0; e < mesh.elements(); ++e) {
    if (solid[std::size_t(e)] == 0) continue;
    for (int i = 0; i < mesh.nodes_per_element; ++i) {
      of_solid[std::size_t(mesh.nodes_of(e)[i])] = 1;
    }
  }
  return of_solid;
}

}  // namespace

template <int Dim>
FrontPressure front_pressure(const MechanicsForms<Dim>& forms, const mesh::Mesh<Dim>& mesh,
                             const SlabState<Dim>& state, const RestingLiquid& liquid) {
  const std::vector<char> of_solid = nodes_of_solid(mesh, state.solid);
  FrontPressure found;
  double difference = 0.0, scale = 0.0, worst = 0.0;  // integrals of squared pressures
  for (int e = 0; e < mesh.elements(); ++e) {
    if (state.solid[std::size_t(e)] != 0) continue;
    const int* node = mesh.nodes_of(e);
    const bool at_front = std::any_of(node, node + mesh.nodes_per_element,
                                      [&](int n) { return of_solid[std::size_t(n)] != 0; });
    if (!at_front) continue;
    const double exact = -liquid.specific_weight * (liquid.level - centroid_height(mesh, e));
    const double error = state.pressure[std::size_t(e) * forms.points()] - exact;
    const double share = forms.volume(std::size_t(e)) * error * error;
    if (share > worst) {
      worst = share;
      found.worst = e;
    }
    difference += share;
    scale += forms.volume(std::size_t(e)) * exact * exact;
  }
  found.error = scale > 0.0 ? std::sqrt(difference / scale) : 0.0;
  return found;
}

template FrontPressure front_pressure(const MechanicsForms<2>&, const mesh::Mesh<2>&,
                                      const SlabState<2>&, const RestingLiquid&);
template FrontPressure front_pressure(const MechanicsForms<3>&, const mesh::Mesh<3>&,
                                      const SlabState<3>&, const RestingLiquid&);

}  // namespace dccast::mechanics
