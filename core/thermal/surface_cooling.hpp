#pragma once

#include <array>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/material/thermal_properties.hpp"
#include "core/thermal/block_body.hpp"
#include "core/thermal/cooling.hpp"
#include "core/thermal/gap_water.hpp"
#include "core/thermal/growth.hpp"
#include "core/thermal/heat_forms.hpp"
#include "core/thermal/water_film.hpp"

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
  /// (bottom node) [1] wetted share where water in the gap touches it; empty without GapWater.
  std::vector<double> gap_wetted;
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
  std::span<const double> bottom_gap{};
  /// Result of follow_growth(), so that the balance includes the growth.
  std::optional<MetalEntry> entry{};
  /// [m2/s] on the narrow face of a solid; absent: as on the wide face.
  std::optional<double> narrow_water_flow = {};
  /// (node) [m] vertical displacement of the side, for zones and water line; empty: zero.
  std::span<const double> rise = {};
  /// (node, face) [m] displacement of the side away from the mould, for zones with a gap; empty:
  /// contact.
  std::span<const double> inward = {};
  /// [m] from which zones and water lines are counted; absent: the metal level.
  std::optional<double> mould_level = {};
  /// (face) [°C]; absent: by the table of the face against time.
  std::array<std::optional<double>, faces> water_temperature = {};
  std::array<double, faces> critical_heat_flux_factor = {1.0, 1.0};  ///< (face) [1]
  double second_water_flow = 0.0;  ///< [m2/s] on every face; 0: it does not run
};

/// Heat flow out through side, bottom and level in one step. The cooling law of each place is fixed
/// at the beginning of the step; the flux follows the nodal states of each iterate.
class SurfaceCooling {
public:
  /// @param cooling  the tables of the case; the body of the block is set up from them
  explicit SurfaceCooling(CoolingSpec cooling);

  /// Adapts the arrays to a mesh. @param nodes  number of nodes
  void resize(std::size_t nodes);
  /// Assigns cooling laws to the boundary for a step. @param field  at the beginning of the step
  void begin_step(const HeatForms& forms, const material::ThermalProperties& properties,
                  const HeatField& field, const HeatStepInput& input);
  /// Fluxes at the states of an iterate. @param state  (node)
  void evaluate(const HeatForms& forms, std::span<const material::ThermalState> state,
                const HeatStepInput& input);
  /// Completes an accepted step: wetted surface and block of the field.
  /// @param field  with the temperatures at the end of the step
  void finish_step(const HeatForms& forms, std::span<const material::ThermalState> state,
                   const HeatStepInput& input, HeatField& field) const;

  const CoolingSpec& spec() const { return cooling_; }
  const std::vector<double>& flux() const { return flux_; }  ///< (node) [W/m] out
  /// (node) dq/dH: derivative of the flux [W/m] by the enthalpy [J/m3].
  const std::vector<double>& flux_derivative() const { return flux_derivative_; }
  const std::array<double, faces>& side_power() const { return side_power_; }  ///< [W/m] by face
  double bottom_power() const { return bottom_power_; }                        ///< [W/m]
  double level_power() const { return level_power_; }                          ///< [W/m] lost
  /// Water of each face, at the last iterate.
  const std::array<FaceWater, faces>& water() const { return water_; }
  /// The water under the butt, at the last iterate; nothing without GapWater.
  const GapStreams& gap_streams() const { return gap_streams_; }

private:
  /// Whether the valve of a face is open in the middle of the step.
  bool water_runs(Face face, const HeatStepInput& input) const;
  double water_temperature(Face face, const HeatStepInput& input) const;  ///< [°C]
  /// Orders the shares of the side by face and column, from above, as the water runs.
  void find_columns(const HeatForms& forms);
  /// Lets the water run down every column of every face. @param side_height  [m] of the undeformed
  /// side
  void lay_water(const HeatForms& forms, const material::ThermalProperties& properties,
                 const HeatField& field, const HeatStepInput& input, double side_height);
  /// A part of a column over which one film runs.
  struct Stretch {
    std::vector<WetPiece> pieces;
    std::vector<WaterPlace> places;  ///< (piece) up to where the film ends
    FilmEnd end;
    double area = 0.0;  ///< [m2]; 2D [m], axisymmetric [m2/rad] of the pieces
  };
  bool second_water_runs(const HeatStepInput& input) const;
  /// Runs a film down shares of a column. @param width  [m]; axisymmetric [m2/rad / m]
  Stretch lay_stretch(std::span<const std::size_t> shares, const Water& water, const Film& supply,
                      double width, const material::ThermalProperties& properties,
                      const HeatField& field, const HeatStepInput& input);
  /// Divides what the first film has left where the second one joins it among both stretches.
  void share_out(double width, Stretch& above, Stretch& below) const;
  /// Takes over the water of a stretch; shares that it does not reach stay dry.
  void keep(std::span<const std::size_t> shares, const Stretch& stretch);
  /// Runs water down the shares of one column. @param width  [m]; axisymmetric [m2/rad / m]
  FilmEnd lay_column(std::span<const std::size_t> shares, double width,
                     const material::ThermalProperties& properties, const HeatField& field,
                     const HeatStepInput& input);
  /// Sets gap, contact and water of each bottom node.
  void lay_bottom(const HeatForms& forms, const material::ThermalProperties& properties,
                  const HeatField& field, const HeatStepInput& input);
  /// Runs water from the edge of the butt into the open gap (gap_water.hpp).
  void lay_gap(const HeatForms& forms, const material::ThermalProperties& properties,
               const HeatField& field, const HeatStepInput& input);
  /// Gives the edge of the butt the water that a column of the side leaves. @param width  [m]
  void supply_edge(const HeatForms& forms, int column, const Film& film, double width);
  /// @param gap  [m] @return  [1] share of a place into which water gets
  double open_share(double gap) const;
  /// Whether water has met the butt on some face, so that it can run into the gap.
  bool water_at_butt(const HeatStepInput& input) const;
  double gap_share() const;  ///< [1] of the water at the edge that runs into the gap
  BottomFlux flux_at_bottom(std::size_t place, const SurfaceState& surface) const;
  SurfaceFlux flux_into_gap(std::size_t place, const SurfaceState& surface) const;
  /// Flux of a share by its law [W/m2] and its derivative by the temperature.
  SurfaceFlux side_flux(std::size_t share, const SurfaceState& surface,
                        const HeatStepInput& input) const;
  /// Adds the fluxes of all shares of the side to the nodes.
  void add_side(std::span<const material::ThermalState> state, const HeatStepInput& input);
  /// Adds the fluxes at the nodes of the bottom or of the level. @return their power [W/m]
  template <class FluxAt>
  double add_patch(const std::vector<int>& nodes, const std::vector<double>& weight,
                   std::span<const material::ThermalState> state, const FluxAt& flux_at);
  /// Stores the wetted share of each side node.
  void store_wetted(std::span<const material::ThermalState> state, const HeatStepInput& input,
                    HeatField& field) const;
  void store_gap_wetted(const HeatForms& forms, std::span<const material::ThermalState> state,
                        const HeatStepInput& input, HeatField& field) const;
  /// @param weight  [m], axisymmetric [m2/rad], in 3D [m2]
  void add(int node, double weight, const SurfaceFlux& flux, const material::ThermalState& state);

  CoolingSpec cooling_;
  std::optional<BlockColumns> block_;
  Water gap_law_;  ///< that of the wide face; steam keeps it out of the gap after `steam_reach`

  // Work vectors of the current step, whose memory is reused.
  std::vector<SideShare> side_;
  std::vector<std::size_t> column_order_;  ///< side shares by face and column, from above
  std::vector<WaterPlace> side_water_;     ///< (side share) if it has water
  std::vector<BottomPlace> bottom_;        ///< (bottom node)
  std::vector<EdgeSupply> edge_supply_;    ///< water that comes down to the edge of the butt
  GapStreams gap_streams_;
  double gap_from_block_ = 0.0;  ///< [W/m] from the block into the water of the gap
  std::array<FaceWater, faces> water_{};
  std::vector<double> flux_;                ///< (node) [W/m] out
  std::vector<double> flux_derivative_;     ///< (node) dq/dH [(W/m)/(J/m3)]
  std::array<double, faces> side_power_{};  ///< [W/m] by face
  double bottom_power_ = 0.0;               ///< [W/m]
  double level_power_ = 0.0;                ///< [W/m]
};

}  // namespace dccast::thermal
