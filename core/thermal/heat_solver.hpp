#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/linalg/direct_solver.hpp"
#include "core/linalg/line_gradients.hpp"
#include "core/material/thermal_properties.hpp"
#include "core/thermal/heat_forms.hpp"
#include "core/thermal/surface_cooling.hpp"

namespace dccast::thermal {

/// Heat balance of one step; per metre of face in plane strain [J/m], per radian in an axisymmetric
/// section [J/rad], total of a solid [J].
struct HeatBalance {
  double stored = 0.0;   ///< [J/m] gained by the slab, including the metal that entered
  double entered = 0.0;  ///< [J/m] brought in by the metal, above 0 °C
  /// [J/m] in through the metal level: conducted from a held level, negative where it loses heat
  double top = 0.0;
  double side = 0.0;    ///< [J/m] out
  double bottom = 0.0;  ///< [J/m] out
  /// |stored + side + bottom - top - entered|, rounding included, relative to all the heat
  /// exchanged.
  double error = 0.0;  ///< [1]
};

/// Outcome of one step. Non-convergence is a result that drives the step control.
struct [[nodiscard]] HeatStepOutcome {
  bool converged = false;
  /// Newton iterations, and calls of the direct solver.
  int iterations = 0;
  int factorizations = 0;
  int solves = 0;
  /// [1] relative to the heat exchanged, before each iteration
  std::vector<double> residual_history;
  HeatBalance balance;
  /// Heat flow out through the side at the end of the step [W/m], per radian [W/rad], of a solid
  /// [W].
  double wall_heat_flux = 0.0;
  std::array<double, faces> face_heat_flux{};  ///< the same by face [W/m]
  double bottom_heat_flux = 0.0;               ///< the same through the bottom [W/m]
  std::array<FaceWater, faces> water{};        ///< by face, at the end of the step
  FaceWater gap_water;                         ///< under the butt, at the end of the step
  double steam_force = 0.0;  ///< [N/m]; billet [N/rad], solid [N]: of the steam under the butt
};

/// Solver for implicit Euler steps of the enthalpy equation, paper eq. (2).
///
///   V (H - H_n)/dt + K Theta(H) + q(H) = 0,
///
/// V lumped volumes, K the stiffness of unit conductivity, Theta the Kirchhoff function, q the flux
/// out through side and bottom at the nodal temperatures. The unknown is the nodal enthalpy, in
/// which everything is single valued even in an isothermal change. Semismooth Newton, formulated in
/// y = dTheta so that the matrix is symmetric positive definite:
///
///   (diag(c/D) + K) y = -R,   c = V/dt + dq/dH,   D = dTheta/dH,   dH = -(R + K y)/c.
///
/// The last line conserves energy in every iterate as far as q is linear, also at D = 0 (y = 0
/// there: such a node is at the temperature of the isothermal change). Convergence is judged by the
/// true residual relative to the heat exchanged. A step is a pure function of mesh, field and
/// input: only work arrays and the symbolic analysis are kept between steps.
///
/// The solver is independent of the dimension: it accesses the mesh through HeatForms only.
class HeatSolver {
public:
  /// @param forms      forms of a mesh that must not move in memory
  /// @param tolerance  residual relative to the heat exchanged in the step [1]
  HeatSolver(material::ThermalProperties properties, CoolingSpec cooling,
             std::unique_ptr<HeatForms> forms, double tolerance = 1e-11,
             int maximum_iterations = 60);

  /// Updates the solver after a change of the mesh; analyses the matrix only if elements changed.
  void update_mesh();
  /// Updates the solver after growth of the mesh and transfers the field.
  /// @param temperature  [°C] of the metal that entered
  MetalEntry follow_growth(HeatField& field, int nodes_per_row, double temperature);

  /// Updates the solver after rows were merged and transfers the field.
  /// @return  relative change of the heat content, caused by rounding [1]
  double follow_merging(HeatField& field, const mesh::MergedRows& merged);

  /// Heat of the metal above the liquidus [J/m]; billet [J/rad], solid [J].
  double superheat(const HeatField& field) const;

  /// A field of uniform temperature [°C].
  HeatField uniform_field(double temperature) const;
  /// Updates temperature and liquid fraction from the enthalpy. @param first  first node whose
  /// enthalpy changed
  void refresh(HeatField& field, std::size_t first = 0) const;

  /// Solves one step.
  /// @param field  on entry at the start of the step, on the present mesh; on return at its end,
  ///               unchanged if the step did not converge
  HeatStepOutcome step(HeatField& field, const HeatStepInput& input);

  const material::ThermalProperties& properties() const { return properties_; }
  const HeatForms& forms() const { return *forms_; }

private:
  /// Computes the conduction of elements that are new.
  void take_elements();
  /// Chooses between conjugate gradients with vertical lines and a factorisation.
  void choose_solver();
  /// Sets up a step: start values, cooling laws, held nodes.
  void prepare(const HeatField& field, const HeatStepInput& input);
  /// @param enthalpy  (node) [J/m3]
  void evaluate(const std::vector<double>& enthalpy, const HeatStepInput& input);
  /// Slopes in the matrix: the true derivatives; c bounded from below; also D at its upper bound.
  enum class Slope { newton, newton_bounded, largest };
  [[nodiscard]] bool factorize(Slope kind, double time_step);  ///< time_step [s]
  [[nodiscard]] bool factorize_newton(double time_step);       ///< time_step [s]
  [[nodiscard]] bool solve_by_lines();
  /// Solves for the Newton direction. @return false if the matrix is not positive definite
  bool newton_direction();
  double relative_residual(double time_step) const;                ///< [1]; time_step [s]
  bool line_search(const HeatStepInput& input, double reference);  ///< reference residual [1]
  /// A step with D at its upper bound everywhere: a contraction, slow but always convergent.
  /// @return false if the matrix is not positive definite
  bool bounded_step(const HeatStepInput& input);
  /// Newton's iterations from the state of prepare(). @return whether the tolerance is reached
  bool iterate(const HeatStepInput& input, HeatStepOutcome& outcome);
  /// Heat balance of the accepted step.
  HeatBalance balance(const HeatStepInput& input) const;

  material::ThermalProperties properties_;
  SurfaceCooling cooling_;
  std::unique_ptr<HeatForms> forms_;
  double tolerance_;  ///< [1]
  int maximum_iterations_;

  /// Conjugate gradients for solids with rows; empty on other meshes, whose matrix is factorised.
  std::optional<linalg::LineGradients> lines_;
  linalg::DirectSolver solver_;
  std::vector<int> top_nodes_;  ///< held at the casting temperature
  std::vector<char> held_;      ///< (node) at the casting temperature

  // Work vectors of the current step, whose memory is reused.
  std::vector<double> enthalpy_n_;  ///< (node) [J/m3] at the start of the step
  std::vector<double> enthalpy_;    ///< (node) [J/m3] of the iterate
  std::vector<double> trial_;       ///< (node) [J/m3] of the line search
  std::vector<material::ThermalState> state_;
  /// (node) [W/m] minus its value at the casting temperature, against round-off
  std::vector<double> kirchhoff_;
  std::vector<double> residual_;    ///< (node) [W/m]; at held nodes the heat the top supplies
  std::vector<double> matrix_;      ///< (entry of the pattern) c/D + K [1], [m] in 3D
  std::vector<double> capacity_;    ///< (node) c in the factor [m^Dim/s]
  std::vector<double> from_slope_;  ///< (node) 1/D [s/m2] where c is too small and dH = y/D is
                                    ///< used, else zero
  std::vector<double> right_, y_, stiffness_y_;  ///< (node) -R, y and K y [W/m], in 3D R, K y [W]
  std::vector<double> direction_;                ///< (node) dH [J/m3]
  double residual_sum_ = 0.0;                    ///< [W/m] sum of absolute values over free nodes
  double moved_ = 0.0;                           ///< [J/m]
  double round_off_ = 0.0;  ///< [J/m] round-off error of residual_sum_ times the step
};

}  // namespace dccast::thermal
