#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/curve.hpp"
#include "core/material/alloy_card.hpp"
#include "core/mechanics/options.hpp"
#include "core/mesh/section_spec.hpp"
#include "core/thermal/cooling_spec.hpp"

/// The description of one casting, complete and in SI units and °C. It mirrors
/// proto/dccast/v1/case.proto field by field; meanings and ranges are documented there. Defaults
/// stand there alone: what is left out here is zero, off, or the first of its kind.

namespace dccast::casting {

/// Table `schedule`: what the plant sets over the casting.
struct Schedule {
  double hold = 0.0;                        ///< [s]
  double filling = 0.0;                     ///< [s] in which the initial depth is poured
  Curve casting_speed;                      ///< [m/s] against time or cast length
  Curve casting_temperature;                ///< [°C] against time or cast length
  Curve water_flow;                         ///< [m2/s] against time or cast length
  Curve narrow_water_flow;                  ///< [m2/s] on the narrow face; empty: as water_flow
  Curve casting_speed_factor = Curve(1.0);  ///< [1] against time or cast length
  Curve water_flow_factor = Curve(1.0);     ///< [1] applied to all water flows
  double casting_speed_shift = 0.0;         ///< [s] delay of the casting-speed table against time
  double water_flow_shift = 0.0;            ///< [s] delay of the water-flow tables against time
  Curve second_water_flow;                  ///< [m2/s] of cooling.second_water, on every face
  Curve metal_level;  ///< [m] above that of the start, against time or cast length; empty: 0
};

/// Table `thermal`: the heat solver, or temperatures from a file.
struct ThermalOptions {
  double tolerance = 0.0;  ///< [1] residual relative to the heat exchanged in a step
  int maximum_iterations = 0;
  std::filesystem::path file;  ///< prescribed temperatures; empty: use the heat solver
};

/// Table `mechanics`.
struct MechanicsCase {
  bool enabled = false;
  double start = 0.0;  ///< [s] time at which the mechanics starts
  mechanics::Options options;
};

/// Table `coupling`: how heat and mechanics act on each other within a step.
struct Coupling {
  bool gap_feedback = false;
  int iterations = 1;
  bool deformed_zones =
      false;  ///< cooling zones act on the deformed side instead of the undeformed one
};

/// Table `time`.
struct TimeControl {
  double end = 0.0;           ///< [s]
  Curve step;                 ///< [s] against time
  double minimum_step = 0.0;  ///< [s]
  double cool_down = 0.0;     ///< [s] after the end, in air, without water and without pouring
  /// [m/s] the casting ends before `end` once its curl moves more slowly; absent: it does not
  std::optional<double> settled{};
};

/// A point of a mean.
struct MonitorShare {
  std::string monitor;
  double weight = 1.0;  ///< [1] positive
};

/// A point of the undeformed slab whose history is reported: x and y in 2D, x, y and z in a quarter
/// slab. Or a mean of such points.
struct Monitor {
  std::string name;
  double x = 0.0;  ///< [m] from the symmetry plane
  double y = 0.0;  ///< [m] above the bottom block; in a quarter slab from the plane y = 0
  /// [m] above the bottom block; quarter slab only
  std::optional<double> z = std::nullopt;
  std::vector<MonitorShare> of{};  ///< of a mean, which has no place
};

/// Coordinates of a monitor [m].
template <int Dim>
std::array<double, std::size_t(Dim)> point_of(const Monitor& monitor) {
  if constexpr (Dim == 2)
    return {monitor.x, monitor.y};
  else
    return {monitor.x, monitor.y, monitor.z.value_or(0.0)};
}

/// Table `output`.
struct OutputOptions {
  double frame_interval = 0.0;  ///< [s]
  bool stresses = false;
  std::string curl{};  ///< monitor whose curl is judged; empty: that with the largest
};

/// Table `checkpoint`: whichever comes first.
struct CheckpointPolicy {
  int every_steps = 0;         ///< 0: not by number of steps
  double every_seconds = 0.0;  ///< [s] wall time; 0: not by time
};

/// What a run does when a limit of validity is exceeded.
enum class WhenLost {
  stop,   ///< the run fails
  go_on,  ///< the run continues; every later step is marked
};

/// Limits of the model; docs/validity.md explains how they were chosen.
struct Validity {
  WhenLost when_lost = WhenLost::stop;
  double maximum_rotation = 0.0;  ///< [rad]
  double maximum_slip = 0.0;      ///< [m]
  double minimum_shell = 0.0;     ///< [m]; 0: any continuous solid shell is enough
};

/// Limits of the findings; docs/findings.md has their sources.
struct Plausibility {
  double minimum_superheat = 0.0;     ///< [K]
  double minimum_shell = 0.0;         ///< [m]
  double minimum_meniscus = 0.0;      ///< [m]
  double greatest_steam_share = 0.0;  ///< [1] force of the steam under the butt, of the weight
  std::optional<double> maximum_mush_strain;      ///< [1]; absent: not judged
  std::optional<double> reference_tear_rate;      ///< [1/s] of a recipe known to be sound
  std::optional<double> reference_tear_pressure;  ///< [Pa] of the same
  double maximum_sump_share = 0.0;                ///< [1] relative to the depth of the metal
  std::optional<double> least_curl;     ///< [m] lower end of the plant's range; absent: none
  std::optional<double> greatest_curl;  ///< [m] upper end of the plant's range; absent: none
};

/// How far mesh and time steps may have put a true figure below and above the computed one.
struct FigureError {
  double below = 0.0, above = 0.0;  ///< in the unit of the figure, or relative to it [1]
  bool is_relative = false;
};

/// Table `limits`: ceilings on the size of a run.
struct Limits {
  std::int64_t maximum_nodes = 0;
  std::int64_t maximum_steps = 0;
};

/// One casting. Members have the names of the tables of a case.
struct Case {
  std::string title;
  mesh::SectionSpec section;
  material::AlloyCard alloy;
  /// [1] solid fraction by which the case gave the coherency; absent: it gave a temperature, or
  /// left it to the card
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
  /// Commit of the program and SHA-256 of the submitted case, kept there too; empty: not known.
  std::string commit = {}, case_sha256 = {};
  /// What mesh and time steps leave uncertain of a curl, where its error was measured, relative to
  /// it [1]; kept in the result file. Core does not know it: it comes with the case. Absent: not
  /// known.
  std::optional<double> relative_curl_error = std::nullopt;
  /// Such errors of the figures that findings judge, by the names that the rules give them
  /// (core/casting/findings/rules_of_step.cpp); they come with the case too.
  std::map<std::string, FigureError> figure_errors{};
};

}  // namespace dccast::casting
