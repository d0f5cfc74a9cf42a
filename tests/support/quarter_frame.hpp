#pragma once

#include "dccast/v1/service.pb.h"

namespace dccast::support {

/// Two by two by two hexahedra of 0.6 x 0.4 x 0.2 m, numbered by x, then y, then z. The lower half
/// is solid. The corner has risen by 20 mm; the wide face has drawn in by 2 % at the butt and by 1
/// % in the middle.
inline v1::Frame quarter_frame() {
  v1::Frame frame;
  frame.set_dimension(3);
  frame.set_nodes_per_element(8);
  frame.set_time_s(250.0);
  frame.set_cast_length_m(0.2);
  frame.set_solidus_c(620);
  frame.set_shell_c(620);
  frame.set_liquidus_c(649);

  const double pull_in[3] = {8e-3, 4e-3, 0.0};
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) {
        for (const double x : {0.3 * i, 0.2 * j, 0.1 * k}) frame.add_node_m(x);
        for (const double u : {0.0, j == 2 ? -pull_in[k] : 0.0, i == 2 && j == 2 ? 20e-3 : 0.0})
          frame.add_displacement_m(u);
        frame.add_temperature_c(k == 0 ? 100.0 : k == 1 ? 400.0 : 680.0);
        if (k > 0) continue;
        frame.add_bottom_node(3 * j + i);
        frame.add_bottom_gap_m(i == 2 && j == 2 ? 20e-3 : 0.0);
        frame.add_bottom_pressure_pa(i == 0 && j < 2 ? 1e4 : 0.0);
      }

  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 2; ++i) {
        const int n = 9 * k + 3 * j + i;
        for (const int node : {n, n + 1, n + 4, n + 3, n + 9, n + 10, n + 13, n + 12})
          frame.add_element_node(node);
      }
  return frame;
}

}  // namespace dccast::support
