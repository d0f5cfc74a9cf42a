#include "server/translate/frame_to_proto.hpp"

namespace dccast::translate {

namespace {

template <class Number, class Field>
void fill(const std::vector<Number>& from, Field* to) {
  to->Add(from.begin(), from.end());
}

}  // namespace

v1::Frame to_proto(const results::Frame& frame, const results::RunHeader& header) {
  v1::Frame to;
  to.set_time_s(frame.time);
  to.set_cast_length_m(frame.cast_length);
  to.set_dimension(frame.dimension);
  to.set_nodes_per_element(frame.nodes_per_element);
  fill(frame.node, to.mutable_node_m());
  fill(frame.element_node, to.mutable_element_node());
  fill(frame.temperature, to.mutable_temperature_c());
  fill(frame.displacement, to.mutable_displacement_m());
  fill(frame.bottom_node, to.mutable_bottom_node());
  fill(frame.bottom_gap, to.mutable_bottom_gap_m());
  fill(frame.bottom_pressure, to.mutable_bottom_pressure_pa());
  to.set_metal_level_m(frame.metal_level);
  to.set_liquidus_c(header.liquidus);
  to.set_solidus_c(header.solidus);
  to.set_shell_c(header.shell);
  return to;
}

}  // namespace dccast::translate
