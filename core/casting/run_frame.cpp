#include "core/casting/run_frame.hpp"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace dccast::casting {

namespace {

/// Mean of a tensor over the points of each element, flat by element and component.
template <int Dim, class PointTensor>
std::vector<double> element_means(std::size_t elements, std::size_t points, PointTensor&& tensor) {
  std::vector<double> means;
  for (std::size_t e = 0; e < elements; ++e) {
    SymmetricTensor<Dim> mean;
    for (std::size_t q = 0; q < points; ++q) {
      mean.add(1.0 / static_cast<double>(points), tensor(e * points + q));
    }
    means.insert(means.end(), mean.value.begin(), mean.value.end());
  }
  return means;
}

template <int Dim>
void add_stresses(const mechanics::SlabState<Dim>& slab, std::size_t elements,
                  results::Frame& frame) {
  const std::size_t points = slab.deviator.size() / elements;
  frame.stress = element_means<Dim>(elements, points, [&](std::size_t i) {
    SymmetricTensor<Dim> stress = slab.deviator[i];
    return stress.add_identity(slab.pressure[i]);
  });
  frame.viscoplastic_strain =
      element_means<Dim>(elements, points, [&](std::size_t i) { return slab.viscoplastic[i]; });
}

template <int Dim>
void add_bottom(const FrameSource<Dim>& source, results::Frame& frame) {
  frame.bottom_node.assign(source.bottom_node.begin(), source.bottom_node.end());
  frame.bottom_gap.assign(source.bottom_gap.begin(), source.bottom_gap.end());
  for (std::size_t i = 0; i < source.bottom_node.size(); ++i) {
    const double area = source.bottom_area[i];
    const double reaction = source.state.slab.reaction[i];
    frame.bottom_pressure.push_back(area > 0.0 ? std::max(0.0, reaction / area) : 0.0);
  }
}

}  // namespace

template <int Dim>
results::Frame frame_of(const FrameSource<Dim>& source) {
  const mesh::Mesh<Dim>& mesh = source.mesh;
  const RunState<Dim>& state = source.state;
  results::Frame frame;
  frame.step = state.step;
  frame.time = state.time;
  frame.cast_length = state.cast_length;
  frame.metal_level = source.metal_level;
  frame.dimension = Dim;
  frame.nodes_per_element = mesh.nodes_per_element;
  frame.node = mesh.node;
  frame.element_node.assign(mesh.element_node.begin(), mesh.element_node.end());
  frame.temperature = state.heat.temperature;
  frame.liquid_fraction = state.heat.liquid_fraction;
  frame.displacement = state.slab.displacement;
  if (source.with_stresses) {
    add_stresses(state.slab, std::size_t(mesh.elements()), frame);
    for (const double t : frame.temperature)
      frame.thermal_strain.push_back(source.properties.thermal_stretch(t) - 1.0);
  }
  add_bottom(source, frame);
  return frame;
}

template results::Frame frame_of(const FrameSource<2>&);
template results::Frame frame_of(const FrameSource<3>&);

}  // namespace dccast::casting
