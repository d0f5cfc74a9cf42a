#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/casting/case.hpp"
#include "core/prescribed/temperature_file.hpp"
#include "core/thermal/heat_solver.hpp"

namespace dccast::casting {

/// Where the temperature comes from: the built-in heat solver, or a file.
class HeatSource {
public:
  /// @throws InvalidCase  the temperature file cannot be read or does not fit the mesh
  /// @param forms         of the mesh of the run, which stays where it is
  HeatSource(const Case& casting_case, std::unique_ptr<thermal::HeatForms> forms);

  /// Takes the mesh as it is now.
  void update_mesh();
  /// @param time  [s] @param temperature  [°C] of all metal where none is prescribed
  thermal::HeatField initial_field(double time, double temperature) const;

  /// Takes the mesh after it has grown and carries the enthalpy over.
  /// @param nodes_per_row        of the mesh
  /// @param casting_temperature  [°C] of the metal that entered
  /// @return                     what the balance needs to know of it
  std::optional<thermal::MetalEntry> follow_growth(thermal::HeatField& field, int nodes_per_row,
                                                   double casting_temperature);

  /// Takes the mesh after rows were merged and carries the field over.
  /// @return  relative change of the heat content [1]
  double follow_merging(thermal::HeatField& field, const mesh::MergedRows& merged);

  thermal::HeatStepOutcome step(thermal::HeatField& field, const thermal::HeatStepInput& input);

private:
  void take_temperature(thermal::HeatField& field, double time) const;

  material::ThermalProperties properties_;
  std::optional<thermal::HeatSolver> solver_;  ///< or
  std::optional<prescribed::TemperatureHistory> history_;
};

}  // namespace dccast::casting
