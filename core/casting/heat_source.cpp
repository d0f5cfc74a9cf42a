#include "core/casting/heat_source.hpp"

#include <utility>

namespace dccast::casting {

HeatSource::HeatSource(const Case& c, std::unique_ptr<thermal::HeatForms> forms)
    : properties_(c.alloy) {
  if (c.thermal.file.empty()) {
    solver_.emplace(properties_, c.cooling, std::move(forms), c.thermal.tolerance,
                    c.thermal.maximum_iterations, c.thermal.two_grids_from_nodes);
    return;
  }
  Faults faults;
  history_ = results::read_temperature_file(c.thermal.file, std::size_t(forms->nodes()), faults);
  if (!history_) throw InvalidCase(faults);
}

void HeatSource::update_mesh() {
  if (solver_) solver_->update_mesh();
}

thermal::HeatField HeatSource::initial_field(double time, double temperature) const {
  if (solver_) return solver_->uniform_field(temperature);
  thermal::HeatField field;
  take_temperature(field, time);
  return field;
}

/// The file gives temperatures; enthalpy and liquid fraction follow from them.
void HeatSource::take_temperature(thermal::HeatField& field, double time) const {
  history_->at(time, field.temperature);
  field.enthalpy.resize(field.temperature.size());
  field.liquid_fraction.resize(field.temperature.size());
  for (std::size_t i = 0; i < field.temperature.size(); ++i) {
    field.enthalpy[i] = properties_.enthalpy(field.temperature[i]);
    field.liquid_fraction[i] = properties_.liquid_fraction(field.enthalpy[i]);
  }
}

std::optional<thermal::MetalEntry> HeatSource::follow_growth(thermal::HeatField& field,
                                                             int nodes_per_row,
                                                             double casting_temperature) {
  if (!solver_) return std::nullopt;
  return solver_->follow_growth(field, nodes_per_row, casting_temperature);
}

double HeatSource::follow_merging(thermal::HeatField& field, const mesh::MergedRows& merged) {
  return solver_ ? solver_->follow_merging(field, merged) : 0.0;
}

thermal::HeatStepOutcome HeatSource::step(thermal::HeatField& field,
                                          const thermal::HeatStepInput& input) {
  if (solver_) return solver_->step(field, input);
  take_temperature(field, input.time);
  thermal::HeatStepOutcome outcome;
  outcome.converged = true;
  return outcome;
}

}  // namespace dccast::casting
