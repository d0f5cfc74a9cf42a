#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/results/finding.hpp"
#include "core/results/validity_loss.hpp"

namespace dccast::results {

/// The fields of one stored instant on the mesh of that instant; mirrors message Frame of
/// service.proto and the group /frames/NNNNNN of SCHEMA.md. Arrays are flat, the last index runs
/// fastest. What a run does not compute stays empty.
struct Frame {
  std::int64_t step = 0;     ///< accepted steps so far; 0 for the initial state
  double time = 0.0;         ///< [s]
  double cast_length = 0.0;  ///< [m]
  double metal_level = 0.0;  ///< [m] above the bottom block

  int dimension = 2;
  int nodes_per_element =
      3;  ///< 3 triangle, 4 quadrilateral (2D) or tetrahedron (3D), 8 hexahedron

  std::vector<double> node;                ///< (node, dimension) [m]
  std::vector<std::int32_t> element_node;  ///< (element, nodes_per_element)
  std::vector<double> temperature;         ///< (node) [°C]
  std::vector<double> liquid_fraction;     ///< (node) [1] 0 to 1
  std::vector<double> displacement;        ///< (node, dimension) [m]
  /// (element, components) [Pa], tension positive; see tensor_components()
  std::vector<double> stress;
  std::vector<double> viscoplastic_strain;  ///< (element, components) [1]

  std::vector<std::int32_t> bottom_node;  ///< in 2D along the bottom, from the symmetry plane
  std::vector<double> bottom_gap;         ///< (bottom node) [m], open positive
  std::vector<double> bottom_pressure;    ///< (bottom node) [Pa], never negative

  std::int64_t nodes() const { return static_cast<std::int64_t>(node.size()) / dimension; }
  std::int64_t elements() const {
    return static_cast<std::int64_t>(element_node.size()) / nodes_per_element;
  }
  bool operator==(const Frame&) const = default;
};

/// Components of a symmetric tensor in a frame: xx, yy, zz, xy in 2D (zz is the direction across
/// the section, around the axis in an axisymmetric one), xx, yy, zz, xy, yz, xz in 3D.
constexpr int tensor_components(int dimension) {
  return dimension == 2 ? 4 : 6;
}

/// A field that a sidecar shows.
struct ShownField {
  std::string name;      ///< under which ParaView lists it
  std::string dataset;   ///< in the frame's group
  bool on_nodes = true;  ///< else on elements
  int components = 1;
};

/// What of a frame a sidecar needs: its size, not its values.
struct FrameOutline {
  double time = 0.0;  ///< [s]
  int dimension = 2;
  int nodes_per_element = 3;
  std::int64_t nodes = 0;
  std::int64_t elements = 0;
  std::vector<ShownField> fields;  ///< those that are there
};

/// What is said once about a run.
struct RunHeader {
  std::string program_version;
  std::string build;      ///< compiler and libraries
  std::string title;      ///< of the case
  std::string case_json;  ///< the case as it was submitted
  std::string section;    ///< "plane_strain", "axisymmetric" or "quarter_slab"
  double liquidus = 0.0;  ///< [°C]
  double solidus = 0.0;   ///< [°C]
  std::vector<std::string> monitor_name;
  int dimension = 2;                                  ///< coordinates of a point, the last one up
  std::vector<std::vector<double>> monitor_position;  ///< (monitor, dimension) [m]
  bool operator==(const RunHeader&) const = default;
};

/// How a run ended.
struct RunSummary {
  std::string outcome = "succeeded";  ///< "succeeded", or the kind of failure: SCHEMA.md
  std::string message;                ///< the cause where it did not succeed, and what followed it
  std::optional<ValidityLoss> validity_lost = std::nullopt;  ///< nothing while all is an answer
  std::vector<Finding> findings{};  ///< each code once, in the order they came
};

}  // namespace dccast::results
