#include "core/casting/heat_source.hpp"

#include <algorithm>

namespace dccast::casting {

HeatSource::HeatSource(const Case& c, const mesh::Mesh2D& mesh)
    : kind_(c.section.kind),
      solver_(material::ThermalProperties(c.alloy), c.cooling, c.section.kind, c.thermal.tolerance,
              c.thermal.maximum_iterations) {
  if (!c.thermal.file.empty()) {
    Faults faults;
    history_ =
        results::read_temperature_file(c.thermal.file, std::size_t(mesh.nodes()), faults);
    if (!history_) throw InvalidCase(faults);
  }
  set_mesh(mesh);
}

void HeatSource::set_mesh(const mesh::Mesh2D& mesh) {
  if (!history_) solver_.set_mesh(mesh);
}

thermal::HeatField HeatSource::initial_field(double time, double temperature) const {
  if (!history_) return solver_.uniform_field(temperature);
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
    field.enthalpy[i] = solver_.properties().enthalpy(field.temperature[i]);
    field.liquid_fraction[i] = solver_.properties().liquid_fraction(field.enthalpy[i]);
  }
}

std::optional<thermal::MetalEntry> HeatSource::follow_growth(thermal::HeatField& field,
                                                             const mesh::Mesh2D& before,
                                                             const mesh::Mesh2D& after,
                                                             int nodes_per_row,
                                                             double casting_temperature) {
  if (history_) return std::nullopt;
  const auto entry =
      thermal::carry_enthalpy(before, after, nodes_per_row, kind_,
                              solver_.properties().enthalpy(casting_temperature), field.enthalpy);
  solver_.set_mesh(after);
  solver_.refresh(field);
  return entry;
}

thermal::HeatStepOutcome HeatSource::step(thermal::HeatField& field,
                                          const thermal::HeatStepInput& input) {
  if (!history_) return solver_.step(field, input);
  take_temperature(field, input.time);
  thermal::HeatStepOutcome outcome;
  outcome.converged = true;
  return outcome;
}

}  // namespace dccast::casting
