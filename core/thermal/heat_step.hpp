#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/thermal/growth.hpp"

namespace dccast::thermal {

/// Temperature field of a mesh. The enthalpy is the state variable; temperature and liquid fraction
/// follow from it.
struct HeatField {
  std::vector<double> enthalpy;         ///< (node) [J/m3]
  std::vector<double> temperature;      ///< (node) [°C]
  std::vector<double> liquid_fraction;  ///< (node) [1]
  /// (node) [W/m3] rate of the enthalpy in the last step. It gives the initial guess of Newton's
  /// method in the next one. The last bits of a solution depend on it, so a resumed run needs it.
  /// Empty before the first step.
  std::vector<double> enthalpy_rate;
  /// (node, face) [1] wetted share of the surface, 0 where a vapour film covers it. Part of the
  /// state; empty if no water has `boiling_follows_flow`.
  std::vector<double> wetted;
  /// (bottom node, depth) [°C] of the bottom block; empty unless the block is a body.
  std::vector<double> block_temperature;
};

/// Input of a heat step besides field and mesh.
struct HeatStepInput {
  double time = 0.0;                 ///< [s] at the end of the step
  double time_step = 0.0;            ///< [s]
  double metal_level = 0.0;          ///< [m] at the end of the step
  double casting_temperature = 0.0;  ///< [°C] at the metal level where that is held
  /// [m2/s] Water runs during a step if the valve is open at its middle. Otherwise, and without
  /// flow, the side below the water line is dry.
  double water_flow = 0.0;
  /// [m], in the order of HeatForms::bottom_nodes(); empty: contact everywhere.
  std::span<const double> bottom_gap;
  /// Result of follow_growth(), so that the balance includes the growth.
  std::optional<MetalEntry> entry;
  /// [m2/s] on the narrow face of a solid; absent: as on the wide face.
  std::optional<double> narrow_water_flow = {};
  /// (node) [m] vertical displacement of the side, for zones and water line; empty: zero.
  std::span<const double> rise = {};
};

}  // namespace dccast::thermal
