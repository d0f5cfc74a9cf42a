#include "core/results/frame.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <tuple>
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

double mean(std::span<const double> stress) {
  return (stress[0] + stress[1] + stress[2]) / 3.0;
}

/// Of the components of tensor_components(): three normal ones, then shears.
double von_mises(std::span<const double> stress) {
  const double pressure = mean(stress);
  double square = 0.0;  // of the deviator
  for (std::size_t i = 0; i < stress.size(); ++i)
    square += i < 3 ? std::pow(stress[i] - pressure, 2) : 2.0 * stress[i] * stress[i];
  return std::sqrt(1.5 * square);
}

/// sqrt(2/3 e : e), which is the axial strain of a bar that creeps without change of volume.
double equivalent(std::span<const double> strain) {
  double square = 0.0;
  for (std::size_t i = 0; i < strain.size(); ++i)
    square += (i < 3 ? 1.0 : 2.0) * strain[i] * strain[i];
  return std::sqrt(2.0 / 3.0 * square);
}

/// The principal values, largest first.
std::array<double, 3> principal(std::span<const double> s) {
  const bool solid = s.size() == 6;
  const double yz = solid ? s[4] : 0.0, xz = solid ? s[5] : 0.0;
  Eigen::Matrix3d tensor;
  tensor << s[0], s[3], xz, s[3], s[1], yz, xz, yz, s[2];
  const Eigen::Vector3d values =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(tensor, Eigen::EigenvaluesOnly).eigenvalues();
  return {values[2], values[1], values[0]};
}

/// A number for each element from its tensor.
template <class Invariant>
std::vector<double> of_elements(const Frame& frame, const std::vector<double>& tensors,
                                Invariant&& invariant) {
  const auto components = static_cast<std::size_t>(tensor_components(frame.dimension));
  std::vector<double> values;
  for (std::size_t i = 0; i < tensors.size(); i += components)
    values.push_back(invariant(std::span(tensors.data() + i, components)));
  return values;
}

std::vector<double> principal_stresses(const Frame& frame) {
  const auto components = static_cast<std::size_t>(tensor_components(frame.dimension));
  std::vector<double> values;
  for (std::size_t i = 0; i < frame.stress.size(); i += components) {
    const auto three = principal({frame.stress.data() + i, components});
    values.insert(values.end(), three.begin(), three.end());
  }
  return values;
}

std::vector<double> on_all_nodes(const Frame& frame, const std::vector<double>& of_bottom,
                                 double elsewhere) {
  if (of_bottom.empty()) return {};
  std::vector<double> values(static_cast<std::size_t>(frame.nodes()), elsewhere);
  for (std::size_t i = 0; i < of_bottom.size(); ++i)
    values[static_cast<std::size_t>(frame.bottom_node[i])] = of_bottom[i];
  return values;
}

bool in_range(const std::vector<std::int32_t>& nodes, std::int64_t count) {
  return std::ranges::all_of(nodes, [&](std::int32_t node) { return node >= 0 && node < count; });
}

}  // namespace

const char* misfit_of(const Frame& frame) {
  if (frame.dimension != 2 && frame.dimension != 3) return "node";
  if (frame.nodes_per_element <= 0) return "element_node";
  const auto nodes = static_cast<std::size_t>(frame.nodes());
  const auto dimension = static_cast<std::size_t>(frame.dimension);
  const auto tensors =
      static_cast<std::size_t>(frame.elements() * tensor_components(frame.dimension));
  const auto rows = static_cast<std::size_t>(frame.nodes_per_element);
  if (frame.node.size() != nodes * dimension) return "node";
  if (frame.element_node.size() % rows != 0 || !in_range(frame.element_node, frame.nodes()))
    return "element_node";
  if (!in_range(frame.bottom_node, frame.nodes())) return "bottom_node";
  const std::size_t bottom = frame.bottom_node.size();
  using Field = std::tuple<const char*, const std::vector<double>&, std::size_t>;
  for (const auto& [name, values, size] :
       std::initializer_list<Field>{{"temperature", frame.temperature, nodes},
                                    {"liquid_fraction", frame.liquid_fraction, nodes},
                                    {"displacement", frame.displacement, nodes * dimension},
                                    {"stress", frame.stress, tensors},
                                    {"viscoplastic_strain", frame.viscoplastic_strain, tensors},
                                    {"thermal_strain", frame.thermal_strain, nodes},
                                    {"bottom_gap", frame.bottom_gap, bottom},
                                    {"bottom_pressure", frame.bottom_pressure, bottom}})
    if (!values.empty() && values.size() != size) return name;
  return nullptr;
}

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
       of_elements(frame, frame.stress, von_mises)});
  add({"mean_stress_pa", "Pa", "mean normal stress, tension positive", false, 1,
       of_elements(frame, frame.stress, mean)});
  add({"principal_stress_pa", "Pa", "principal stresses, the largest first", false, 3,
       principal_stresses(frame)});
  add({"equivalent_viscoplastic_strain", "1", "of viscoplastic_strain: sqrt(2/3 e : e)", false, 1,
       of_elements(frame, frame.viscoplastic_strain, equivalent)});
  add({"contact_pressure_pa", "Pa", "bottom_pressure_pa on all nodes, zero away from the bottom",
       true, 1, on_all_nodes(frame, frame.bottom_pressure, 0.0)});
  add({"gap_m", "m", "bottom_gap_m on all nodes, NaN away from the bottom", true, 1,
       on_all_nodes(frame, frame.bottom_gap, std::numeric_limits<double>::quiet_NaN())});
  return fields;
}

}  // namespace dccast::results
