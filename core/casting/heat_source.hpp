#pragma once

#include <optional>
#include <vector>

#include "core/casting/case.hpp"
#include "core/results/temperature_file.hpp"
#include "core/thermal/heat_solver.hpp"

namespace dccast::casting {

/// Where the temperature comes from: the built-in heat solver, or a file.
class HeatSource {
public:
  /// @throws InvalidCase  the temperature file cannot be read or does not fit the mesh
  HeatSource(const Case& casting_case, const mesh::Mesh2D& mesh);

  void set_mesh(const mesh::Mesh2D& mesh);
  thermal::HeatField initial_field(double time, double temperature) const;

  /// Carries the enthalpy to the grown mesh. @return what the balance needs to know of it
  std::optional<thermal::MetalEntry> follow_growth(thermal::HeatField& field,
                                                   const mesh::Mesh2D& before,
                                                   const mesh::Mesh2D& after, int nodes_per_row,
                                                   double casting_temperature);

  thermal::HeatStepOutcome step(thermal::HeatField& field, const thermal::HeatStepInput& input);

private:
  void take_temperature(thermal::HeatField& field, double time) const;

  mesh::SectionKind kind_;
  thermal::HeatSolver solver_;
  std::optional<results::TemperatureHistory> history_;
};

}  // namespace dccast::casting
