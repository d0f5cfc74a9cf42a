#include "core/results/derived_fields.hpp"

#include <cmath>
#include <span>
#include <utility>

namespace dccast::results {

namespace {

/// (node, 2) as (node, 3), the last one zero.
std::vector<double> padded(const std::vector<double>& plane) {
  std::vector<double> values;
  values.reserve(plane.size() / 2 * 3);
  for (std::size_t i = 0; i + 1 < plane.size(); i += 2)
    values.insert(values.end(), {plane[i], plane[i + 1], 0.0});
  return values;
}

std::vector<double> solid_fraction(const std::vector<double>& liquid_fraction) {
  std::vector<double> values;
  values.reserve(liquid_fraction.size());
  for (const double liquid : liquid_fraction) values.push_back(1.0 - liquid);
  return values;
}

/// Of the components of tensor_components(): three normal ones, then shears.
double von_mises(std::span<const double> stress) {
  const double mean = (stress[0] + stress[1] + stress[2]) / 3.0;
  double square = 0.0;  // of the deviator
  for (std::size_t i = 0; i < stress.size(); ++i)
    square += i < 3 ? (stress[i] - mean) * (stress[i] - mean) : 2.0 * stress[i] * stress[i];
  return std::sqrt(1.5 * square);
}

std::vector<double> von_mises_of(const Frame& frame) {
  const auto components = static_cast<std::size_t>(tensor_components(frame.dimension));
  std::vector<double> values;
  for (std::size_t i = 0; i < frame.stress.size(); i += components)
    values.push_back(von_mises({frame.stress.data() + i, components}));
  return values;
}

std::vector<double> on_all_nodes(const Frame& frame, const std::vector<double>& of_bottom) {
  if (of_bottom.empty()) return {};
  std::vector<double> values(static_cast<std::size_t>(frame.nodes()), 0.0);
  for (std::size_t i = 0; i < of_bottom.size(); ++i)
    values[static_cast<std::size_t>(frame.bottom_node[i])] = of_bottom[i];
  return values;
}

}  // namespace

std::vector<DerivedField> derived_fields(const Frame& frame) {
  std::vector<DerivedField> fields;
  const auto add = [&](DerivedField field) {
    if (!field.values.empty()) fields.push_back(std::move(field));
  };
  if (frame.dimension == 2)
    add({"displacement_xyz_m", "m", "displacement, the third component zero", true, 3,
         padded(frame.displacement)});
  add({"solid_fraction", "1", "0 liquid, 1 solid", true, 1, solid_fraction(frame.liquid_fraction)});
  add({"von_mises_pa", "Pa", "von Mises stress of the mean stress of the element", false, 1,
       von_mises_of(frame)});
  add({"contact_pressure_pa", "Pa", "bottom_pressure_pa on all nodes, zero away from the bottom",
       true, 1, on_all_nodes(frame, frame.bottom_pressure)});
  return fields;
}

}  // namespace dccast::results
