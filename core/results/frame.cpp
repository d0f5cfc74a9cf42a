#include "core/results/frame.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <type_traits>
#include <utility>

namespace dccast::results {

namespace {

/// Extends (node, 2) to (node, 3), the last component zero.
std::vector<double> pad_to_3d(const std::vector<double>& plane) {
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

/// sqrt(3/2 s : s) of the deviator s. The first three components are the normal ones, the others
/// count twice in the product.
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

/// Principal values of a stress, largest first.
std::array<double, 3> principal(std::span<const double> s) {
  const bool solid = s.size() == 6;
  const double yz = solid ? s[4] : 0.0, xz = solid ? s[5] : 0.0;
  Eigen::Matrix3d tensor;
  tensor << s[0], s[3], xz, s[3], s[1], yz, xz, yz, s[2];
  const Eigen::Vector3d values =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(tensor, Eigen::EigenvaluesOnly).eigenvalues();
  return {values[2], values[1], values[0]};
}

/// Numbers of each element from its tensor. @param invariant  returns an array or one number
template <class Invariant>
std::vector<double> element_invariants(const Frame& frame, const std::vector<double>& tensors,
                                       Invariant&& invariant) {
  const auto components = static_cast<std::size_t>(tensor_components(frame.dimension));
  std::vector<double> values;
  for (std::size_t i = 0; i < tensors.size(); i += components) {
    const auto numbers = invariant(std::span(tensors.data() + i, components));
    if constexpr (std::is_same_v<decltype(numbers), const double>)
      values.push_back(numbers);
    else
      values.insert(values.end(), numbers.begin(), numbers.end());
  }
  return values;
}

/// Values of the bottom nodes as a field on all nodes.
std::vector<double> spread_to_nodes(const Frame& frame, const std::vector<double>& bottom_values,
                                    double elsewhere) {
  if (bottom_values.empty()) return {};
  std::vector<double> values(static_cast<std::size_t>(frame.nodes()), elsewhere);
  for (std::size_t i = 0; i < bottom_values.size(); ++i)
    values[static_cast<std::size_t>(frame.bottom_node[i])] = bottom_values[i];
  return values;
}

bool in_range(const std::vector<std::int32_t>& nodes, std::int64_t count) {
  return std::ranges::all_of(nodes, [&](std::int32_t node) { return node >= 0 && node < count; });
}

}  // namespace

/// All arrays of a frame: the one list that writers and readers of results go through.
std::span<const FrameArray> frame_arrays() {
  using On = FrameArray::On;
  using Rank = FrameArray::Rank;

  static constexpr std::array arrays{
      FrameArray{"temperature", "temperature_c", "degC", "temperature", On::nodes, Rank::scalar,
                 &Frame::temperature},
      FrameArray{"liquid_fraction", "liquid_fraction", "1", "0 solid, 1 liquid", On::nodes,
                 Rank::scalar, &Frame::liquid_fraction},
      FrameArray{"displacement", "displacement_m", "m", "displacement", On::nodes, Rank::vector,
                 &Frame::displacement},

      FrameArray{"stress", "stress_pa", "Pa",
                 "stress, tension positive: xx, yy, zz, xy (then yz, xz)", On::elements,
                 Rank::tensor, &Frame::stress},
      FrameArray{"viscoplastic_strain", "viscoplastic_strain", "1",
                 "viscoplastic strain: xx, yy, zz, xy (then yz, xz)", On::elements, Rank::tensor,
                 &Frame::viscoplastic_strain},
      FrameArray{"thermal_strain", "thermal_strain", "1",
                 "free linear strain since the liquidus, contraction negative", On::nodes,
                 Rank::scalar, &Frame::thermal_strain},

      FrameArray{"tear_rate", "tear_rate_per_s", "s-1",
                 "mean viscoplastic strain rate in the window of hot tears so far", On::elements,
                 Rank::scalar, &Frame::tear_rate},
      FrameArray{"tear_pressure", "tear_pressure_pa", "Pa",
                 "pressure drop of the melt that feeds the mush so far", On::elements, Rank::scalar,
                 &Frame::tear_pressure},

      FrameArray{"bottom_gap", "bottom_gap_m", "m", "gap to the bottom block, open positive",
                 On::bottom, Rank::scalar, &Frame::bottom_gap},
      FrameArray{"bottom_pressure", "bottom_pressure_pa", "Pa", "contact pressure", On::bottom,
                 Rank::scalar, &Frame::bottom_pressure},
  };
  return arrays;
}

std::size_t FrameArray::rows(const Frame& frame) const {
  if (on == On::bottom) return frame.bottom_node.size();
  return static_cast<std::size_t>(on == On::nodes ? frame.nodes() : frame.elements());
}

int FrameArray::components(int dimension) const {
  if (rank == Rank::scalar) return 1;
  return rank == Rank::vector ? dimension : tensor_components(dimension);
}

const char* find_misfit(const Frame& frame) {
  if (frame.dimension != 2 && frame.dimension != 3) return "node";
  if (frame.nodes_per_element <= 0) return "element_node";
  if (frame.node.size() % static_cast<std::size_t>(frame.dimension) != 0) return "node";
  if (frame.element_node.size() % static_cast<std::size_t>(frame.nodes_per_element) != 0 ||
      !in_range(frame.element_node, frame.nodes()))
    return "element_node";
  if (!in_range(frame.bottom_node, frame.nodes())) return "bottom_node";

  for (const FrameArray& array : frame_arrays()) {
    const std::size_t size = (frame.*array.values).size();
    const auto components = static_cast<std::size_t>(array.components(frame.dimension));
    if (size != 0 && size != array.rows(frame) * components) return array.name;
  }
  return nullptr;
}

std::vector<double> flat(const std::vector<std::vector<double>>& points) {
  std::vector<double> values;
  for (const auto& point : points) values.insert(values.end(), point.begin(), point.end());
  return values;
}

std::vector<std::vector<double>> split_points(const std::vector<double>& flat, std::size_t count) {
  if (count == 0 ? !flat.empty() : flat.size() % count != 0)
    throw std::out_of_range("incomplete coordinates of a point");

  std::vector<std::vector<double>> points(count);
  auto from = flat.begin();
  for (auto& point : points) {
    const auto end = from + static_cast<std::ptrdiff_t>(flat.size() / count);
    point.assign(std::exchange(from, end), end);
  }
  return points;
}

std::vector<DerivedField> derived_fields(const Frame& frame) {
  std::vector<DerivedField> fields;
  const auto add = [&](DerivedField field) {
    if (!field.values.empty()) fields.push_back(std::move(field));
  };

  if (frame.dimension == 2)
    add({"displacement_xyz_m", "m", "displacement, the third component zero", true, 3,
         pad_to_3d(frame.displacement)});
  add({"solid_fraction", "1", "0 liquid, 1 solid", true, 1, solid_fraction(frame.liquid_fraction)});

  // Invariants of the tensors.
  add({"von_mises_pa", "Pa", "von Mises stress of the mean stress of the element", false, 1,
       element_invariants(frame, frame.stress, von_mises)});
  add({"mean_stress_pa", "Pa", "mean normal stress, tension positive", false, 1,
       element_invariants(frame, frame.stress, mean)});
  add({"principal_stress_pa", "Pa", "principal stresses, the largest first", false, 3,
       element_invariants(frame, frame.stress, principal)});
  add({"equivalent_viscoplastic_strain", "1", "of viscoplastic_strain: sqrt(2/3 e : e)", false, 1,
       element_invariants(frame, frame.viscoplastic_strain, equivalent)});

  // Fields of the bottom.
  add({"contact_pressure_pa", "Pa", "bottom_pressure_pa on all nodes, zero away from the bottom",
       true, 1, spread_to_nodes(frame, frame.bottom_pressure, 0.0)});
  add({"gap_m", "m", "bottom_gap_m on all nodes, NaN away from the bottom", true, 1,
       spread_to_nodes(frame, frame.bottom_gap, std::numeric_limits<double>::quiet_NaN())});
  return fields;
}

}  // namespace dccast::results
