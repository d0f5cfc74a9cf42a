#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/thermal/growth.hpp"

namespace dccast::thermal {

/// Temperature field of a mesh. The enthalpy is its state; temperature and liquid fraction follow.
struct HeatField {
  std::vector<double> enthalpy;         ///< (node) [J/m3]
  std::vector<double> temperature;      ///< (node) [°C]
  std::vector<double> liquid_fraction;  ///< (node) [1]
  /// (node) [W/m3] Of the enthalpy over the last step, from which Newton's method starts the next.
  /// The bits of a solution depend on it, so a resumed run needs it; empty before the first step.
  std::vector<double> enthalpy_rate;
  /// (node) Water touched the metal in the last step, not a vapour film. State like the enthalpy;
  /// empty where no water follows its flow.
  std::vector<char> wetted;
};

/// What a heat step needs besides field and mesh.
struct HeatStepInput {
  double time = 0.0;                 ///< [s] at the end of the step
  double time_step = 0.0;            ///< [s]
  double metal_level = 0.0;          ///< [m] at the end of the step
  double casting_temperature = 0.0;  ///< [°C] held at the metal level when the top is poured
  /// [m2/s]. Water runs in a step in whose middle the valve is open; else, and without flow, the
  /// side below the water line is dry.
  double water_flow = 0.0;
  /// [m], in the order of HeatForms::bottom_nodes(); empty: contact everywhere.
  std::span<const double> bottom_gap;
  /// What follow_growth() gave, so that the balance covers the growth too.
  std::optional<MetalEntry> entry;
  /// [m2/s] of the narrow face of a solid; absent: as on the wide one.
  std::optional<double> narrow_water_flow = {};
  /// (node) [m] by which the side has risen, for zones and water line; empty: not at all.
  std::span<const double> rise = {};
};

}  // namespace dccast::thermal
