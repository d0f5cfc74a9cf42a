#include "core/casting/slab_run.hpp"

namespace dccast::casting {

namespace {

/// Mean of a tensor over the points of each element, flat by element and component.
template <class PointTensor>
std::vector<double> element_means(std::size_t elements, std::size_t points, PointTensor&& tensor) {
  std::vector<double> means;
  for (std::size_t e = 0; e < elements; ++e) {
    SymmetricTensor<2> mean;
    for (std::size_t q = 0; q < points; ++q) {
      mean.add(1.0 / static_cast<double>(points), tensor(e * points + q));
    }
    means.insert(means.end(), mean.value.begin(), mean.value.end());
  }
  return means;
}

}  // namespace

results::Frame SlabRun::take_frame() {
  while (state_.next_frame <= state_.time + 1e-9) {
    state_.next_frame += case_.output.frame_interval;
  }
  const mesh::Mesh2D& m = mesh();
  const mechanics::SlabState<2>& slab = state_.slab;
  results::Frame frame;
  frame.step = state_.step;
  frame.time = state_.time;
  frame.cast_length = state_.cast_length;
  frame.metal_level = metal_level();
  frame.nodes_per_element = m.nodes_per_element;
  frame.node = m.node;
  frame.element_node.assign(m.element_node.begin(), m.element_node.end());
  frame.temperature = state_.heat.temperature;
  frame.liquid_fraction = state_.heat.liquid_fraction;
  frame.displacement = slab.displacement;
  if (case_.output.stresses && case_.mechanics.enabled) {
    const std::size_t elements = std::size_t(m.elements());
    const std::size_t points = slab.deviator.size() / elements;
    frame.stress = element_means(elements, points, [&](std::size_t i) {
      SymmetricTensor<2> stress = slab.deviator[i];
      return stress.add_identity(slab.pressure[i]);
    });
    frame.viscoplastic_strain =
        element_means(elements, points, [&](std::size_t i) { return slab.viscoplastic[i]; });
  }
  const auto& bottom = mechanics_.bottom_nodes();
  frame.bottom_node.assign(bottom.begin(), bottom.end());
  for (std::size_t i = 0; i < bottom.size(); ++i) {
    frame.bottom_gap.push_back(
        std::max(0.0, slab.displacement[2 * std::size_t(bottom[i]) + 1]));
    const double area = mechanics_.bottom_area()[i];
    frame.bottom_pressure.push_back(area > 0.0 ? std::max(0.0, slab.reaction[i] / area) : 0.0);
  }
  return frame;
}

}  // namespace dccast::casting
