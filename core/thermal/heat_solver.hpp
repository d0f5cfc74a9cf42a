#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/linalg/conjugate_gradients.hpp"
#include "core/linalg/direct_solver.hpp"
#include "core/linalg/two_grid.hpp"
#include "core/material/thermal_properties.hpp"
#include "core/thermal/heat_forms.hpp"
#include "core/thermal/surface_cooling.hpp"

namespace dccast::thermal {

/// Heat of one step; per metre of face in plane strain [J/m], per radian in an axisymmetric section
/// [J/rad], whole of a solid [J].
struct HeatBalance {
  double stored = 0.0;   ///< [J/m] gained by the slab, with the metal that entered
  double entered = 0.0;  ///< [J/m] with the metal
  double top = 0.0;      ///< [J/m] conducted in at the metal level
  double side = 0.0;     ///< [J/m] out
  double bottom = 0.0;   ///< [J/m] out
  double moved = 0.0;    ///< [J/m] all heat that moved, the measure of the errors
  /// |stored + side + bottom - top - entered|, rounding included, relative to `moved`.
  double error = 0.0;  ///< [1]
};

struct HeatStepOutcome {
  bool converged = false;
  int iterations = 0;
  int factorizations = 0;
  int solves = 0;
  std::vector<double> residual_history;  ///< [1] of the heat that moved, before each iteration
  HeatBalance balance;
  /// [W/m] out through the side at the end of the step, per radian [W/rad], of a solid [W].
  double wall_heat_flux = 0.0;
  std::array<double, faces> face_heat_flux{};  ///< the same by face [W/m]
  double bottom_heat_flux = 0.0;               ///< the same through the bottom
};

/// One implicit Euler step of the enthalpy equation, paper eq. (2), at a time.
///
///   V (H - H_n)/dt + K Theta(H) + q(H) = 0,
///
/// V lumped volumes, K the stiffness of unit conductivity, Theta the Kirchhoff function, q the flux
/// out through side and bottom at the nodal temperatures. The unknown is the nodal enthalpy, in
/// which everything is single valued even in an isothermal change. Semismooth Newton, written in
/// y = dTheta so that the matrix is symmetric positive definite:
///
///   (diag(c/D) + K) y = -R,   c = V/dt + dq/dH,   D = dTheta/dH,   dH = -(R + K y)/c.
///
/// The last line conserves energy in every iterate as far as q is linear, D = 0 included (y = 0
/// there: such a node is at the temperature of the change). Convergence is judged on the true
/// residual against the heat that moves. A step is a pure function of mesh, field and input:
/// nothing is kept from the step before but storage and the symbolic analysis.
///
/// The solver knows no dimension: the mesh lies behind its forms.
class HeatSolver {
public:
  /// @param forms      of a mesh, which stays where it is
  /// @param tolerance  residual relative to the heat that moves in the step [1]
  /// @param two_grids_from_nodes  of an extruded solid, from which a step is solved by conjugate
  ///                              gradients with two grids: docs/large-solids.md
  HeatSolver(material::ThermalProperties properties, CoolingSpec cooling,
             std::unique_ptr<HeatForms> forms, double tolerance = 1e-11,
             int maximum_iterations = 60, int two_grids_from_nodes = 5000);

  /// Takes the mesh as it is now; analyses the matrix only if elements changed.
  void update_mesh();
  /// Takes the mesh after it has grown and carries the field over. @param temperature  [°C] of the
  /// metal that entered
  MetalEntry follow_growth(HeatField& field, int nodes_per_row, double temperature);

  /// Takes the mesh after rows were merged and carries the field over.
  /// @return  relative change of the heat content: rounding [1]
  double follow_merging(HeatField& field, const mesh::MergedRows& merged);

  /// A field of one temperature [°C] on the mesh.
  HeatField uniform_field(double temperature) const;
  /// Temperature and liquid fraction from the enthalpy. @param first  node whose enthalpy changed
  void refresh(HeatField& field, std::size_t first = 0) const;

  /// @param field  at the start of the step, carried to the present mesh; at its end on return,
  ///               unchanged if the step did not converge
  HeatStepOutcome step(HeatField& field, const HeatStepInput& input);

  const material::ThermalProperties& properties() const { return properties_; }
  const CoolingSpec& cooling() const { return cooling_.spec(); }
  const HeatForms& forms() const { return *forms_; }

private:
  void take_elements();
  void choose_solver();
  void prepare(const HeatField& field, const HeatStepInput& input);
  void evaluate(const std::vector<double>& enthalpy, const HeatStepInput& input);
  /// What the matrix takes: true derivatives; c bounded from below; D at its upper bound too.
  enum class Slope { newton, newton_bounded, largest };
  bool factorize(Slope kind, double time_step);
  bool factorize_newton(double time_step);
  bool factorize_matrix();
  bool solve_by_two_grid();
  bool newton_direction();
  double relative_residual(double time_step) const;
  bool line_search(const HeatStepInput& input, double reference);
  bool bounded_step(const HeatStepInput& input);
  bool iterate(const HeatStepInput& input, HeatStepOutcome& outcome);
  void store_rate(HeatField& field, double time_step) const;
  HeatBalance balance(const HeatStepInput& input) const;

  material::ThermalProperties properties_;
  SurfaceCooling cooling_;
  std::unique_ptr<HeatForms> forms_;
  double tolerance_;  ///< [1]
  int maximum_iterations_;
  int two_grids_from_nodes_;

  linalg::DirectSolver solver_;
  std::unique_ptr<linalg::TwoGrid<1>> two_grid_;  ///< in its place where a factor is too large
  linalg::ConjugateGradients gradients_;
  std::vector<int> top_nodes_;  ///< held at the casting temperature
  std::vector<char> held_;      ///< (node) at the casting temperature

  // Of the step under way; storage kept from step to step.
  std::vector<double> enthalpy_n_;
  std::vector<double> enthalpy_;
  std::vector<double> trial_;
  std::vector<material::ThermalState> state_;
  std::vector<double> kirchhoff_;  ///< less that of the casting temperature, against round-off
  std::vector<double> residual_;   ///< (node) [W/m]; at held nodes the heat the top supplies
  std::vector<double> matrix_;
  std::vector<char> stiff_;         ///< (node) held, or nearly so by its diagonal
  std::vector<double> capacity_;    ///< c in the factor
  std::vector<double> from_slope_;  ///< 1/D where dH = y/D because c is too small, else zero
  std::vector<double> right_, y_, stiffness_y_, direction_;
  double residual_sum_ = 0.0;  ///< [W/m] sum of absolute values over free nodes
  double moved_ = 0.0;         ///< [J/m]
  double round_off_ = 0.0;     ///< [J/m] of residual_sum_ times the step
};

}  // namespace dccast::thermal
