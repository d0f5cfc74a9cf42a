#pragma once

#include <array>
#include <cmath>
#include <functional>

#include "dccast/v1/service.pb.h"

/// A quarter slab that stands free and has cooled evenly at each height: its contraction is known.
namespace dccast::frames::testing {

inline constexpr double liquidus_c = 649.0;
inline constexpr std::array height_m{0.0, 0.05, 0.2, 0.4};
inline constexpr std::array along_m{0.0, 0.3, 0.66};
inline constexpr std::array opening_m{0.300, 0.300, 0.290};

inline double density(double temperature_c) {
  return 2700.0 - 0.5 * temperature_c;
}

/// Length over that at the liquidus.
inline double stretch(double temperature_c) {
  return std::cbrt(density(liquidus_c) / density(temperature_c));
}

inline void add_point(v1::Curve& curve, double at, double value) {
  curve.add_at(at);
  curve.add_value(value);
}

inline v1::Case quarter_slab() {
  v1::Case solved;
  for (std::size_t i = 1; i < along_m.size(); ++i)
    add_point(*solved.mutable_section()->mutable_half_thickness_m(), along_m[i], opening_m[i]);
  for (const double temperature_c : {0.0, 1000.0})
    add_point(*solved.mutable_alloy()->mutable_density_kg_per_m3(), temperature_c,
              density(temperature_c));
  return solved;
}

/// A block that stands free and has cooled from its liquidus to this temperature at each height.
inline v1::Frame cooled(const std::function<double(double height_m)>& temperature_c) {
  v1::Frame frame;
  frame.set_time_s(1000.0);
  frame.set_cast_length_m(0.95);
  frame.set_dimension(3);
  frame.set_nodes_per_element(8);
  frame.set_liquidus_c(liquidus_c);
  frame.set_solidus_c(620.0);
  frame.set_shell_c(620.0);
  for (const double z : height_m)
    for (std::size_t i = 0; i < along_m.size(); ++i)
      for (const double share : {1.0, 0.4, 0.0}) {  // in no order
        frame.add_temperature_c(temperature_c(z));
        for (const double x : {along_m[i], share * opening_m[i], z}) {
          frame.add_node_m(x);
          frame.add_displacement_m(x * (stretch(temperature_c(z)) - 1.0));
        }
      }
  return frame;
}

inline double uniform(double) {
  return 320.0;
}

/// Hot metal in the last row.
inline double hot_above(double height) {
  return height > 0.3 ? 640.0 : 320.0;
}

}  // namespace dccast::frames::testing
