#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/material/mechanical_properties.hpp"
#include "core/mechanics/slab_state.hpp"
#include "core/mechanics/slab_supports.hpp"
#include "core/mechanics/solve_step.hpp"
#include "core/mesh/row_merging.hpp"

namespace dccast::mechanics {

/// What the mechanics of a step needs to know of its surroundings.
struct SlabStepInput {
  std::span<const double> temperature;  ///< (node) at the end of the step [°C]
  double time_step = 0.0;               ///< [s]
  double metal_level = 0.0;             ///< h(t) [m]
};

/// The checks every step is reported with; they are of the step problem itself at the displacement
/// found, whatever law the algorithm that found it solves by.
struct SlabChecks {
  double equilibrium_residual = 0.0;   ///< [1] relative to the forces that act
  double complementarity_error = 0.0;  ///< [1] of gap and reaction, against 1 mm and the weight
  double bottom_reaction = 0.0;        ///< [N/m] upwards, of a billet [N/rad], in 3D [N]
  double weight = 0.0;                 ///< [N/m], of a billet [N/rad], in 3D [N]
  double contact_length = 0.0;         ///< [m] of the bottom that stands on the block, in 3D [m2]
  double wall_reaction = 0.0;          ///< [N/m] of walls on released sides, [N/rad], in 3D [N]
  /// Root mean square error of the pressure in the liquid along its front against rho_l g depth,
  /// relative; zero without liquid.
  double liquid_pressure_error = 0.0;
  int worst_liquid = -1;  ///< element with the largest share in that error; -1 without one
};

/// A state on its way to a mesh of which rows of cells are merged.
template <int Dim>
struct ProjectedState {
  SlabState<Dim> state;                       ///< of the merged mesh but for its inelastic strain
  std::vector<SymmetricTensor<Dim>> elastic;  ///< (element, point) [1], with its thermal part
  std::vector<double> force;  ///< (node, Dim) [N] of the stress before, on the merged mesh
  double weight = 0.0;        ///< [N] before
};

/// What a merging of rows has changed that it should not.
struct MergeChecks {
  double mass_error = 0.0;         ///< [1] relative change of the weight
  double equilibrium_error = 0.0;  ///< [1] nodal forces it put out of balance, by those that act
};

/// The slab as a mechanical body (paper sections 2.2 and 3.4): which elements carry stress, what
/// stands for the liquid, what the mould and the block hold, and one step in time of all that.
template <int Dim>
class SlabMechanics {
public:
  using State = SlabState<Dim>;
  using Mesh = mesh::Mesh<Dim>;

  /// @param forms  of the elements the meshes are made of
  SlabMechanics(std::unique_ptr<MechanicsForms<Dim>> forms,
                material::MechanicalProperties properties, Options options);

  /// Takes a mesh or its new coordinates; analyses the matrix only if elements are new.
  /// @param mesh         must stay where it is until the next call
  /// @param first_moved  first element that is new or has moved
  void set_mesh(const Mesh& mesh, int first_moved = 0);

  /// Gives the block a shape. @param gap  by bottom node, how far the block lies below it before
  /// anything has moved [m]; empty: flat. @throws std::invalid_argument on another number of nodes
  void set_initial_gap(std::vector<double> gap);

  /// A slab without displacement and history.
  State initial_state() const;

  /// Carries a state over to a mesh that has grown by stretching and adding rows of cells: new
  /// nodes take the displacement of the node below, elements keep their elastic strain. The mesh of
  /// the state must be the present one; `set_mesh` is called for the new one.
  void follow_growth(State& state, const Mesh& grown, int nodes_per_row, int first_moved);

  /// Projects a state of the present mesh on the rows of cells that are about to be made of it:
  /// nodes keep their displacement, cells their mean elastic and viscoplastic strain and its first
  /// moment. A cell made of a solid and a liquid one counts as liquid, and solidifies anew;
  /// liquid that is merged is at rest.
  /// @param temperature  (node) [°C] @throws std::logic_error of triangles and tetrahedra
  ProjectedState<Dim> projected(const State& state, const mesh::MergedRows& merged,
                                std::span<const double> temperature);
  /// Takes the mesh after rows were merged, and the state projected on it.
  /// @param temperature  (node of the merged mesh) [°C]
  MergeChecks follow_merging(State& state, ProjectedState<Dim> projected, const Mesh& merged_mesh,
                             std::span<const double> temperature);

  /// Begins the mechanics: what is below the coherency temperature is a shell without stress.
  void start(State& state, std::span<const double> temperature) const;

  /// One step. On convergence the state is that of its end, else unspecified.
  StepOutcome step(State& state, const SlabStepInput& input);

  /// Checks of the last converged step.
  const SlabChecks& checks() const { return checks_; }
  const std::vector<int>& bottom_nodes() const { return supports_.bottom_nodes(); }
  const std::vector<double>& bottom_area() const { return supports_.bottom_area(); }
  /// Gap between a bottom node, by its place in bottom_nodes(), and the block [m].
  double bottom_gap(const State& state, std::size_t place) const;
  const Options& options() const { return options_; }
  std::size_t points() const { return points_; }  ///< of an element
  const CostSplit& cost() const { return work_.cost; }

private:
  using Tensor = SymmetricTensor<Dim>;

  void new_pattern();
  void choose_solver();
  void find_supports();
  void set_rotations(std::span<const double> displacement, std::span<const char> solid);
  std::vector<double> forces_of_stress(const State& state, double& acting) const;
  void solidify(State& state, int e, double metal_level, double at) const;
  void set_phases(State& state, const SlabStepInput& input);
  void forget_history(State& state, std::size_t e) const;
  void set_materials(const State& state, const SlabStepInput& input);
  void set_weight(const State& state, std::span<const double> temperature);
  StepUnknowns<Dim> begin(State& state, const SlabStepInput& input);
  ForceScales evaluate_end(StepUnknowns<Dim>& unknowns);
  void finish(State& state, StepUnknowns<Dim>& unknowns, const StepOutcome& outcome,
              const SlabStepInput& input);
  void check_balance(const StepUnknowns<Dim>& unknowns, const ForceScales& forces);
  void store_supports(State& state, StepUnknowns<Dim>& unknowns);

  std::unique_ptr<MechanicsForms<Dim>> forms_;
  std::size_t points_;  ///< of an element
  material::MechanicalProperties properties_;
  Options options_;
  const Mesh* mesh_ = nullptr;
  std::vector<int> element_unknown_;  ///< (element, unknown of it) of the pattern
  linalg::SparsityPattern pattern_;
  ElementParts parts_;  ///< of a solid
  Workspace work_;
  StepProblem<Dim> problem_;
  SlabChecks checks_;
  SlabSupports<Dim> supports_;
  std::vector<double> displacement_;  ///< by unknown, of the start of the step [m]
};

}  // namespace dccast::mechanics
