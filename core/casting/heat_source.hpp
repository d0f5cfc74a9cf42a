#pragma once

#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "core/casting/case/case.hpp"
#include "core/results/temperature_file.hpp"
#include "core/thermal/heat_solver.hpp"

namespace dccast::casting {

/// Provides the temperature: from the built-in heat solver or from a file.
class HeatSource {
public:
  /// @throws InvalidCase  the temperature file cannot be read or does not fit the mesh
  /// @param forms         heat forms of the run's mesh, which must not move in memory
  HeatSource(const Case& c, std::unique_ptr<thermal::HeatForms> forms) : properties_(c.alloy) {
    if (c.thermal.file.empty()) {
      solver_.emplace(properties_, c.cooling, std::move(forms), c.thermal.tolerance,
                      c.thermal.maximum_iterations);
      return;
    }
    Faults faults;
    history_ = results::read_temperature_file(c.thermal.file, std::size_t(forms->nodes()), faults);
    if (!history_) throw InvalidCase(faults);
  }

  /// Updates the solver after the mesh has changed.
  void update_mesh() {
    if (solver_) solver_->update_mesh();
  }
  /// @param time         [s]
  /// @param temperature  [°C] initial temperature of all metal if none is prescribed
  thermal::HeatField initial_field(double time, double temperature) const {
    if (solver_) return solver_->uniform_field(temperature);
    thermal::HeatField field;
    take_temperature(field, time);
    return field;
  }

  /// Heat of the metal above the liquidus, @see HeatSolver; zero if temperatures are prescribed.
  double superheat(const thermal::HeatField& field) const {
    return solver_ ? solver_->superheat(field) : 0.0;
  }

  /// (bottom node) tributary area, @see HeatForms::bottom_weight(); empty if temperatures are
  /// prescribed.
  std::span<const double> bottom_area() const {
    if (!solver_) return {};
    return solver_->forms().bottom_weight();
  }

  /// Updates the solver after growth of the mesh and transfers the enthalpy to the new mesh.
  /// @param nodes_per_row        nodes per row of the mesh
  /// @param casting_temperature  [°C] of the metal that entered
  /// @return                     heat brought in, for the energy balance; empty if temperatures are
  ///                             prescribed
  std::optional<thermal::MetalEntry> follow_growth(thermal::HeatField& field, int nodes_per_row,
                                                   double casting_temperature) {
    if (!solver_) return std::nullopt;
    return solver_->follow_growth(field, nodes_per_row, casting_temperature);
  }

  /// Updates the solver after rows were merged and transfers the field to the merged mesh.
  /// @return  relative change of the heat content [1]
  double follow_merging(thermal::HeatField& field, const mesh::MergedRows& merged) {
    return solver_ ? solver_->follow_merging(field, merged) : 0.0;
  }

  /// One step of the solver, or the prescribed temperatures at its end. @param field  unchanged if
  /// the step did not converge
  thermal::HeatStepOutcome step(thermal::HeatField& field, const thermal::HeatStepInput& input) {
    if (solver_) return solver_->step(field, input);
    take_temperature(field, input.time);
    thermal::HeatStepOutcome outcome;
    outcome.converged = true;
    return outcome;
  }

private:
  /// Sets the field to the prescribed temperatures at a time [s]; enthalpy and liquid fraction
  /// follow from them.
  void take_temperature(thermal::HeatField& field, double time) const {
    history_->at(time, field.temperature);
    field.enthalpy.resize(field.temperature.size());
    field.liquid_fraction.resize(field.temperature.size());
    for (std::size_t i = 0; i < field.temperature.size(); ++i) {
      field.enthalpy[i] = properties_.enthalpy(field.temperature[i]);
      field.liquid_fraction[i] = properties_.liquid_fraction(field.enthalpy[i]);
    }
  }

  material::ThermalProperties properties_;
  std::optional<thermal::HeatSolver> solver_;           ///< empty if temperatures are prescribed
  std::optional<results::TemperatureHistory> history_;  ///< empty if the solver is used
};

}  // namespace dccast::casting
