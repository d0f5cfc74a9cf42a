#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "core/base/curve.hpp"
#include "core/material/alloy_card.hpp"
#include "core/mechanics/options.hpp"
#include "core/mesh/section_spec.hpp"
#include "core/thermal/cooling_spec.hpp"

/// The description of one casting, complete and in SI units and °C. It mirrors
/// proto/dccast/v1/case.proto field by field; meanings, ranges and defaults are documented there.

namespace dccast::casting {

struct Schedule {
  double hold = 0.0;                        ///< [s]
  Curve casting_speed;                      ///< [m/s] against time or cast length
  Curve casting_temperature;                ///< [°C] against time or cast length
  Curve water_flow;                         ///< [m2/s] against time or cast length
  Curve narrow_water_flow;                  ///< [m2/s] of the narrow face; empty: as water_flow
  Curve casting_speed_factor = Curve(1.0);  ///< [1] against time or cast length
  Curve water_flow_factor = Curve(1.0);     ///< [1] of all water flows
  double casting_speed_shift = 0.0;         ///< [s] by which its table against time comes later
  double water_flow_shift = 0.0;            ///< [s] the same of the tables of the water flows
};

struct ThermalOptions {
  std::optional<double> initial_temperature;  ///< [°C]; absent: the casting temperature
  double tolerance = 1e-11;  ///< [1] residual relative to the heat that moves in a step
  int maximum_iterations = 60;
  int two_grids_from_nodes = 5000;  ///< of an extruded solid; no key of a case: the measured rule
  std::filesystem::path file;  ///< prescribed temperature; empty: the heat solver
};

struct MechanicsCase {
  bool enabled = true;
  double start = 0.0;  ///< [s]
  mechanics::Options options;
};

struct Coupling {
  bool gap_feedback = true;
  int iterations = 1;
  bool deformed_zones = false;  ///< cooling zones are met at the height to which the side has risen
};

struct TimeControl {
  double end = 0.0;            ///< [s]
  Curve step;                  ///< [s] against time
  double minimum_step = 1e-3;  ///< [s]
};

/// In the undeformed slab. In 2D x and y; of a quarter slab x, y and z.
struct Monitor {
  std::string name;
  double x = 0.0;  ///< [m] from the symmetry plane
  double y = 0.0;  ///< [m] above the bottom block; of a quarter slab from the plane y = 0
  /// [m] above the bottom block, of a quarter slab
  std::optional<double> z = std::nullopt;
};

/// Its coordinates [m].
template <int Dim>
std::array<double, std::size_t(Dim)> point_of(const Monitor& monitor) {
  if constexpr (Dim == 2)
    return {monitor.x, monitor.y};
  else
    return {monitor.x, monitor.y, monitor.z.value_or(0.0)};
}

struct OutputOptions {
  double frame_interval = 10.0;  ///< [s]
  bool stresses = true;
};

struct CheckpointPolicy {
  int every_steps = 50;         ///< 0: none by steps
  double every_seconds = 30.0;  ///< [s] of wall time; 0: none by time
};

enum class WhenLost {
  stop,   ///< the run fails
  go_on,  ///< every later step is marked
};

/// Limits of the model; how they were chosen stands in docs/validity.md.
struct Validity {
  WhenLost when_lost = WhenLost::stop;
  double maximum_liquid_pressure_error = 0.15;  ///< [1] relative; of the prestressed liquid only
  double maximum_rotation = 10.0 * std::numbers::pi / 180.0;  ///< [rad]
  double maximum_slip = 0.02;                                 ///< [m]
  double minimum_shell = 0.0;                                 ///< [m]; 0: any solid path
};

/// Limits of the findings; how they were chosen stands in docs/findings.md.
struct Plausibility {
  double minimum_superheat = 5.0;       ///< [K]
  double minimum_shell = 5e-3;          ///< [m]
  double maximum_mush_strain = 0.005;   ///< [1]
  double maximum_sump_share = 0.95;     ///< [1] of the metal's depth
  std::optional<double> least_curl;     ///< [m] of the plant's band; absent: no lower edge
  std::optional<double> greatest_curl;  ///< [m] absent: no upper edge
};

struct Limits {
  std::int64_t maximum_nodes = 400000;
  std::int64_t maximum_steps = 200000;
};

struct Case {
  std::string title;
  mesh::SectionSpec section;
  material::AlloyCard alloy;
  /// [1] that the alloy's coherency was given by; absent: as a temperature, or left to the card
  std::optional<double> coherency_solid_fraction;
  Schedule schedule;
  thermal::CoolingSpec cooling;
  ThermalOptions thermal;
  MechanicsCase mechanics;
  Coupling coupling;
  TimeControl time;
  std::vector<Monitor> monitors;
  OutputOptions output;
  CheckpointPolicy checkpoint;
  Validity validity;
  Plausibility plausibility;
  Limits limits;
  /// The case in the form it was submitted (JSON), kept in the result file for provenance.
  std::string source_json;
};

}  // namespace dccast::casting
