#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/case/case.hpp"
#include "core/results/temperature_file.hpp"
#include "core/thermal/heat_solver.hpp"

namespace dccast::casting {

/// Provides the temperature: from the built-in heat solver or from a file.
class HeatSource {
public:
  /// @throws InvalidCase  the temperature file cannot be read or does not fit the mesh
  /// @param forms         heat forms of the run's mesh, which must not move in memory
  HeatSource(const Case& casting_case, std::unique_ptr<thermal::HeatForms> forms);

  /// Updates the solver after the mesh has changed.
  void update_mesh();
  /// @param time         [s]
  /// @param temperature  [°C] initial temperature of all metal if none is prescribed
  thermal::HeatField initial_field(double time, double temperature) const;

  /// Heat of the metal above the liquidus, @see HeatSolver; zero if temperatures are prescribed.
  double superheat(const thermal::HeatField& field) const {
    return solver_ ? solver_->superheat(field) : 0.0;
  }

  /// Updates the solver after growth of the mesh and transfers the enthalpy to the new mesh.
  /// @param nodes_per_row        nodes per row of the mesh
  /// @param casting_temperature  [°C] of the metal that entered
  /// @return                     heat brought in, for the energy balance; empty if temperatures are
  ///                             prescribed
  std::optional<thermal::MetalEntry> follow_growth(thermal::HeatField& field, int nodes_per_row,
                                                   double casting_temperature);

  /// Updates the solver after rows were merged and transfers the field to the merged mesh.
  /// @return  relative change of the heat content [1]
  double follow_merging(thermal::HeatField& field, const mesh::MergedRows& merged);

  thermal::HeatStepOutcome step(thermal::HeatField& field, const thermal::HeatStepInput& input);

private:
  /// Sets the field to the prescribed temperatures at a time [s].
  void take_temperature(thermal::HeatField& field, double time) const;

  material::ThermalProperties properties_;
  std::optional<thermal::HeatSolver> solver_;              ///< empty if temperatures are prescribed
  std::optional<results::TemperatureHistory> history_;  ///< empty if the solver is used
};

}  // namespace dccast::casting
