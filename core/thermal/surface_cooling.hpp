#pragma once

#include <array>
#include <span>
#include <utility>
#include <vector>

#include "core/material/thermal_properties.hpp"
#include "core/thermal/boiling.hpp"
#include "core/thermal/cooling.hpp"
#include "core/thermal/heat_forms.hpp"
#include "core/thermal/heat_step.hpp"

namespace dccast::thermal {

/// Heat flow out through side and bottom in one step. The cooling law of each place is fixed at the
/// beginning of the step; the flux follows the nodal states of each iterate.
class SurfaceCooling {
public:
  explicit SurfaceCooling(CoolingSpec cooling) : cooling_(std::move(cooling)) {}

  /// Adapts the arrays to a mesh. @param nodes  number of nodes
  void resize(std::size_t nodes);
  /// Assigns cooling laws to the side for a step. @param field  at the beginning of the step
  void begin_step(const HeatForms& forms, const material::ThermalProperties& properties,
                  const HeatField& field, const HeatStepInput& input);
  /// Fluxes at the states of an iterate. @param state  (node)
  void evaluate(const HeatForms& forms, std::span<const material::ThermalState> state,
                const HeatStepInput& input);
  /// Records in the field where water touches the metal; only with `boiling_follows_flow`.
  void mark_wetted(HeatField& field) const;

  const CoolingSpec& spec() const { return cooling_; }
  const std::vector<double>& flux() const { return flux_; }  ///< (node) [W/m] out
  /// (node) dq/dH: derivative of the flux [W/m] by the enthalpy [J/m3].
  const std::vector<double>& flux_derivative() const { return flux_derivative_; }
  const std::array<double, faces>& side_power() const { return side_power_; }  ///< [W/m] by face
  double bottom_power() const { return bottom_power_; }                        ///< [W/m]

private:
  bool water_runs(Face face, const HeatStepInput& input) const;
  /// @return [1]
  double film_share_of(const SideShare& share, const material::ThermalProperties& properties,
                       const HeatField& field) const;
  SurfaceFlux side_flux(std::size_t share, const SurfaceState& surface,
                        const HeatStepInput& input) const;
  void add_side(std::span<const material::ThermalState> state, const HeatStepInput& input);
  void add_bottom(const HeatForms& forms, std::span<const material::ThermalState> state,
                  const HeatStepInput& input);
  /// @param weight  [m], axisymmetric [m2/rad], in 3D [m2]
  void add(int node, double weight, const SurfaceFlux& flux, const material::ThermalState& state);

  CoolingSpec cooling_;

  // Of the current step; the memory is reused between steps.
  std::vector<SideShare> side_;
  std::array<Boiling, faces> boiling_;
  std::vector<double> film_share_;          ///< (side share) [1]
  std::vector<double> flux_;                ///< (node) [W/m] out
  std::vector<double> flux_derivative_;     ///< (node) dq/dH [(W/m)/(J/m3)]
  std::array<double, faces> side_power_{};  ///< [W/m] by face
  double bottom_power_ = 0.0;               ///< [W/m]
};

}  // namespace dccast::thermal
