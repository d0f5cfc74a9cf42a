#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/results/step_report.hpp"

namespace dccast::results {

/// The fields at one stored time, on the mesh at that time; mirrors message Frame of service.proto
/// and the group /frames/NNNNNN of SCHEMA.md. Arrays are flat with the last index fastest. Fields
/// that a run does not compute are empty.
struct Frame {
  std::int64_t step = 0;     ///< number of accepted steps so far; 0 for the initial state
  double time = 0.0;         ///< [s]
  double cast_length = 0.0;  ///< [m]
  double metal_level = 0.0;  ///< [m] above the bottom block

  /// Coordinates of a node.
  int dimension = 2;
  /// 3 triangle, 4 quadrilateral (2D) or tetrahedron (3D), 8 hexahedron
  int nodes_per_element = 3;

  std::vector<double> node;                ///< (node, dimension) [m]
  std::vector<std::int32_t> element_node;  ///< (element, nodes_per_element)
  std::vector<double> temperature;         ///< (node) [°C]
  std::vector<double> liquid_fraction;     ///< (node) [1] 0 to 1
  std::vector<double> displacement;        ///< (node, dimension) [m]
  /// (element, components) [Pa], tension positive; see tensor_components()
  std::vector<double> stress;
  std::vector<double> viscoplastic_strain;  ///< (element, components) [1]
  std::vector<double> thermal_strain;       ///< (node) [1] free linear strain since the liquidus
  std::vector<double> tear_rate;            ///< (element) [1/s] mean in the window of hot tears
  std::vector<double> tear_pressure;        ///< (element) [Pa] drop of the melt that feeds the mush

  std::vector<std::int32_t> bottom_node;  ///< in 2D along the bottom, from the symmetry plane
  std::vector<double> bottom_gap;         ///< (bottom node) [m], open positive
  std::vector<double> bottom_pressure;    ///< (bottom node) [Pa], never negative

  /// Numbers of nodes and elements.
  std::int64_t nodes() const { return static_cast<std::int64_t>(node.size()) / dimension; }
  std::int64_t elements() const {
    return static_cast<std::int64_t>(element_node.size()) / nodes_per_element;
  }
  bool operator==(const Frame&) const = default;
};

/// Number of components of a symmetric tensor in a frame: xx, yy, zz, xy in 2D (zz is the
/// out-of-plane direction, in an axisymmetric section the hoop direction), xx, yy, zz, xy, yz, xz
/// in 3D.
constexpr int tensor_components(int dimension) {
  return dimension == 2 ? 4 : 6;
}

/// An array of results in a frame, empty if the run does not compute it. Journal, writer, reader
/// and sidecar all use frame_arrays(), the table of these.
struct FrameArray {
  /// Where the values of an array belong, and how many a place has.
  enum class On { nodes, elements, bottom };
  enum class Rank { scalar, vector, tensor };

  const char* name;     ///< in the journal
  const char* dataset;  ///< in the frame's group
  const char* unit;
  /// What it is, as the attribute `meaning` in HDF5 has it.
  const char* meaning;
  On on;
  Rank rank;
  std::vector<double> Frame::*values;  ///< [`unit`]

  /// Number of nodes or elements.
  std::size_t rows(const Frame& frame) const;
  /// Numbers for one node or element: 1, the dimension, or tensor_components().
  int components(int dimension) const;
};

/// All arrays, in the order of SCHEMA.md.
std::span<const FrameArray> frame_arrays();

/// Finds an array of a frame that does not fit its mesh: its size is wrong, or it names a node that
/// does not exist. @return its name; null if all arrays fit
const char* find_misfit(const Frame& frame);

/// Data stored once per run.
struct RunHeader {
  std::string program_version;
  std::string build;          ///< compiler and libraries
  std::string commit{};       ///< of the program's sources
  std::string title;          ///< of the case
  std::string case_sha256{};  ///< of the submitted case; empty: not a job
  std::string case_json;      ///< the case as it was submitted
  std::string section;        ///< "plane_strain", "axisymmetric" or "quarter_slab"
  double liquidus = 0.0;      ///< [°C]
  double solidus = 0.0;       ///< [°C]
  double shell = 0.0;         ///< [°C] metal below this temperature counts as shell
  /// [1] half width of the discretisation error, relative to the curl; absent: not known
  std::optional<double> relative_curl_error = std::nullopt;
  /// Names of the monitors, in the order of the case.
  std::vector<std::string> monitor_name;
  int dimension = 2;  ///< number of coordinates; the last one points upwards
  /// (monitor, dimension) [m]; NaN of a mean of others
  std::vector<std::vector<double>> monitor_position;
  bool operator==(const RunHeader&) const = default;
};

/// How a run ended.
struct RunSummary {
  std::string outcome = "succeeded";  ///< "succeeded", or the kind of failure: SCHEMA.md
  std::string message;  ///< if it did not succeed: the cause and the failures that followed
  std::optional<ValidityLoss> validity_lost = std::nullopt;  ///< absent: valid to the end
  std::vector<Finding> findings{};  ///< each code once, in the order in which they were raised
  std::vector<Margin> margins{};    ///< to the limits of findings, found or not
};

/// Coordinates of points one after the other [m].
std::vector<double> flat(const std::vector<std::vector<double>>& points);
/// The inverse of flat() for `count` points. @throws std::out_of_range  the values do not fill them
std::vector<std::vector<double>> split_points(const std::vector<double>& flat, std::size_t count);

/// A field of a frame that is derived from other fields and stored for visualisation programs.
struct DerivedField {
  const char* name;  ///< dataset in the frame's group
  const char* unit;
  const char* meaning;
  bool on_nodes;               ///< else on elements
  int components = 1;          ///< per node or element
  std::vector<double> values;  ///< [`unit`]
};

/// The derived fields that the fields of a frame permit: the displacement with three components if
/// it has two, the solid fraction, invariants of stress and viscoplastic strain, and contact
/// pressure and gap as fields on all nodes.
std::vector<DerivedField> derived_fields(const Frame& frame);

}  // namespace dccast::results
