#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/material/mechanical_properties.hpp"
#include "core/mechanics/melt.hpp"
#include "core/mechanics/slab_supports.hpp"
#include "core/mechanics/solve_step.hpp"
#include "core/mesh/row_merging.hpp"

namespace dccast::mechanics {

/// The complete mechanical state of a slab between steps, as stored in a checkpoint.
template <int Dim>
struct SlabState {
  using Tensor = SymmetricTensor<Dim>;

  bool started = false;              ///< false: the slab has no displacement and no history yet
  std::vector<double> displacement;  ///< (node, Dim) [m]
  std::vector<char> solid;           ///< (element) below coherency
  std::vector<char> carries;         ///< (element) carries load, @see Melt::carrying()
  /// (element, point) stress-free strain [1]: reference strain at solidification minus its thermal
  /// stretch, plus the viscoplastic strain since then.
  std::vector<Tensor> inelastic;
  std::vector<Tensor> viscoplastic;  ///< (element, point) viscoplastic part of it [1]
  /// (element, point) equivalent viscoplastic strain gained in the cold since solidification, which
  /// has hardened the metal [1]; empty if the alloy has no yield limit
  std::vector<double> hardened;
  std::vector<Tensor> deviator;  ///< (element, point) stress deviator [Pa]
  std::vector<double> pressure;  ///< (element, point) mean normal stress [Pa]
  std::vector<char> contact;     ///< (bottom node) closed
  /// (unknown) whether it leant on the mould at the end of the last step, from which the next one
  /// starts; set for those of melt
  std::vector<char> leaning;
  std::vector<double> contact_multiplier;  ///< (bottom node) [Pa], for sbm only
  std::vector<double> reaction;            ///< (bottom node) in the last step [N/m], billet [N/rad]
};

/// Boundary data of a mechanical step. An element has the properties of its mean temperature.
struct SlabStepInput {
  std::span<const double> element_temperature;  ///< (element) mean at the end of the step [°C]
  std::span<const double> node_temperature;  ///< (node) at the end of the step [°C]; only the side
  double time_step = 0.0;                    ///< [s]
  double metal_level = 0.0;                  ///< h(t) [m]
  /// (element) mean at the start of the step, on the mesh of its end [°C]. Empty: elements that
  /// solidify do so at the start of the step.
  std::span<const double> element_temperature_n{};
  std::optional<double> mould_level = {};  ///< [m] on which the mould hangs; absent: metal_level
};

/// Checks reported for every step. They evaluate the step problem itself at the computed
/// displacement, independently of the algorithm.
struct SlabChecks {
  double equilibrium_residual = 0.0;   ///< [1] relative to the acting forces
  double complementarity_error = 0.0;  ///< [1] of gap and reaction, relative to 1 mm and the weight
  double bottom_reaction = 0.0;        ///< [N/m] upwards, of a billet [N/rad], in 3D [N]
  double weight = 0.0;  ///< [N/m] of the metal that carries load and, by its pressure, of the melt
                        ///< on it; of a billet [N/rad], in 3D [N]
  double contact_length = 0.0;  ///< [m] length of the bottom in contact with the block, in 3D [m2]
  double wall_reaction = 0.0;   ///< [N/m] of the mould on sides that lean on it, [N/rad], in 3D [N]
};

/// A state that is being transferred to a mesh with merged rows.
template <int Dim>
struct ProjectedState {
  SlabState<Dim> state;  ///< on the merged mesh, except for its inelastic strain
  std::vector<SymmetricTensor<Dim>> elastic;  ///< (element, point) [1], thermal part included
  std::vector<double> force;  ///< (node, Dim) [N] of the stress before merging, on the merged mesh
  double weight = 0.0;        ///< [N] before merging
};

/// Errors introduced by a merging of rows.
struct MergeChecks {
  double mass_error = 0.0;         ///< [1] relative change of the weight
  double equilibrium_error = 0.0;  ///< [1] unbalanced nodal forces, relative to the acting forces
};

/// Forces of the stress in a state [N], per metre of face in a section [N/m].
struct StressForces {
  std::vector<double> nodal;  ///< (unknown) along the coordinate axes
  double acting = 0.0;        ///< root of the sum of squares of all element forces
};

/// The slab as a mechanical body (paper sections 2.2 and 3.4): it decides which elements carry
/// load, models the liquid, applies the supports by mould and block, and solves one time step.
template <int Dim>
class SlabMechanics {
public:
  using State = SlabState<Dim>;
  using Mesh = mesh::Mesh<Dim>;

  /// @param forms  forms of the elements of the meshes
  SlabMechanics(std::unique_ptr<MechanicsForms<Dim>> forms,
                material::MechanicalProperties properties, Options options);

  /// Sets the mesh, or updates its coordinates; analyses the matrix only if there are new elements.
  /// @param mesh         must not move in memory until the next call
  /// @param first_moved  first element that is new or has moved
  void set_mesh(const Mesh& mesh, int first_moved = 0);

  /// Sets the shape of the block.
  /// @param gap  (bottom node) initial distance of the block below the slab [m]; empty: flat
  /// @throws std::invalid_argument  wrong number of nodes
  void set_initial_gap(std::vector<double> gap);

  /// A slab without displacement or history.
  State initial_state() const;

  /// Transfers a state to a mesh that has grown by stretching and adding rows of cells: new nodes
  /// get the displacement of the node below, elements keep their elastic strain. @pre the state
  /// belongs to the present mesh; set_mesh() is called with the new one
  void follow_growth(State& state, const Mesh& grown, int nodes_per_row, int first_moved);

  /// Projects a state of the present mesh on the merged rows of cells: nodes keep their
  /// displacement; cells keep the mean and the first moment of elastic and viscoplastic strain. A
  /// cell made of a solid and a liquid one counts as liquid and solidifies again; merged liquid is
  /// at rest.
  /// @param temperature  (element) mean [°C]
  /// @throws std::logic_error  the elements are triangles or tetrahedra
  ProjectedState<Dim> projected(const State& state, const mesh::MergedRows& merged,
                                std::span<const double> temperature);
  /// Sets the mesh with merged rows and completes the state that was projected on it.
  /// @param temperature  (element of the merged mesh) mean [°C]
  MergeChecks follow_merging(State& state, ProjectedState<Dim> projected, const Mesh& merged_mesh,
                             std::span<const double> temperature);

  /// Starts the mechanics: metal below the coherency temperature becomes a stress-free shell.
  /// @param temperature  (element) mean [°C]
  void start(State& state, std::span<const double> temperature) const;

  /// Solves one step. If it converges, the state is that at its end, otherwise unspecified.
  StepOutcome step(State& state, const SlabStepInput& input);

  /// Displacements of a cold slab that has been lifted off its block (node, Dim) [m]: without
  /// weight, block and mould, at the temperatures of `input`, without creep. They are known up to a
  /// vertical motion. Empty where melt is left, where symmetry leaves the slab other rigid motions,
  /// or where no equilibrium was found. @pre the state belongs to the present mesh
  std::vector<double> off_block(State state, const SlabStepInput& input);

  /// Checks of the last converged step.
  const SlabChecks& checks() const { return checks_; }
  const std::vector<int>& bottom_nodes() const { return supports_.bottom_nodes(); }
  /// (bottom node) tributary area [m^(Dim-1)], axisymmetric: [m2/rad].
  const std::vector<double>& bottom_area() const { return supports_.bottom_area(); }
  const material::MechanicalProperties& properties() const { return properties_; }
  /// Gap between a bottom node and the block, along its normal [m]. @param place  index in
  /// bottom_nodes()
  double bottom_gap(const State& state, std::size_t place) const;
  const Options& options() const { return options_; }
  std::size_t points() const { return points_; }  ///< of an element
  const CostSplit& cost() const { return work_.cost; }

private:
  using Tensor = SymmetricTensor<Dim>;

  /// Lays out matrix and parts for the present mesh, which has other elements than before.
  void new_pattern();
  /// Chooses between factorisation and two grids by the number of unknowns.
  void choose_solver();
  /// Finds the boundaries and sets their frames.
  void find_supports();
  /// @param displacement  by unknown [m]
  void set_rotations(std::span<const double> displacement, std::span<const char> solid);
  /// Nodal forces of the stress in a state, by unknown [N]. @param acting  set to their scale [N]
  StressForces forces_of_stress(const State& state) const;

  /// An element that begins to carry load within the step: it solidifies, or what it is part of
  /// reaches its supports.
  struct Birth {
    std::size_t element = 0;
    double temperature = 0.0;  ///< [°C] from which its thermal strain counts
    double share = 1.0;        ///< [1] of the step that is left after its solidification, not zero
  };
  /// Time and temperature at which an element solidifies within the step, by linear interpolation
  /// of the temperature in time.
  Birth birth_of(std::size_t e, const SlabStepInput& input) const;
  /// Scales moduli and hardening of an element by the share of the step that is left after its
  /// solidification; its stress begins at minus the pressure of the melt.
  void set_newborn(const Birth& birth);
  /// Sets the reference strain of a new solid from its stress at the end of the step.
  /// @param u  displacement at the end of the step, by unknown [m]
  void complete_newborn(State& state, const Birth& birth, std::span<const double> u) const;

  /// Marks elements as coherent by their mean temperature, and those that carry load.
  void set_phases(State& state, const SlabStepInput& input);
  /// Makes the element stress-free at the strain of the start of the step, without history.
  void forget_history(State& state, std::size_t e) const;
  /// Pressure of melt at the centre of an element [Pa]. @param level  to which it stands [m]
  double melt_pressure(int e, double level) const;
  /// Whether melt is no part of the body.
  bool melt_is_outside() const { return options_.liquid == Liquid::pressure; }
  void set_materials(const State& state, const SlabStepInput& input);
  void set_solid(int e, double at, double metal_level);  ///< at [°C], metal_level [m]
  /// Weight of the body, and pressure of the melt on it.
  void set_loads(const State& state, const SlabStepInput& input);
  /// (element) [N/m3] of those for which counts(element) holds, else zero.
  template <class Counts>
  std::vector<double> specific_weights(const State& state, std::span<const double> temperature,
                                       const Counts& counts) const;
  /// Weight of all metal [N/m], of a billet [N/rad], in 3D [N].
  /// @param temperature  (element) mean [°C]
  double whole_weight(const State& state, std::span<const double> temperature) const;
  /// Sets up block, planes of symmetry and mould, and holds the melt.
  void set_supports(State& state, const SlabStepInput& input, StepUnknowns<Dim>& unknowns);
  /// Initial values and the complete problem of the step.
  StepUnknowns<Dim> begin(State& state, const SlabStepInput& input);
  /// Evaluates the solution of an algorithm that uses another law with the law of the step problem.
  ForceScales evaluate_end(StepUnknowns<Dim>& unknowns);
  /// Accepts a converged step: stores strains, stresses and contact in the state.
  void finish(State& state, StepUnknowns<Dim>& unknowns, const StepOutcome& outcome);
  /// Sets weight, residual and complementarity error of the checks.
  void check_balance(const StepUnknowns<Dim>& unknowns, const ForceScales& forces);
  /// Stores contact state and reactions of block and walls.
  void store_supports(State& state, StepUnknowns<Dim>& unknowns);
  std::unique_ptr<MechanicsForms<Dim>> forms_;
  std::size_t points_;  ///< of an element
  material::MechanicalProperties properties_;
  Options options_;
  const Mesh* mesh_ = nullptr;
  std::vector<int> element_unknown_;  ///< (element, unknown of the element) for the pattern
  linalg::SparsityPattern pattern_;
  ElementParts parts_;  ///< of a solid
  Workspace work_;
  StepProblem<Dim> problem_;
  SlabChecks checks_;
  SlabSupports<Dim> supports_;
  Melt<Dim> melt_;
  std::vector<double> displacement_;   ///< by unknown, at the start of the step [m]
  std::vector<char> of_body_;          ///< (node) part of the body in this step
  std::vector<std::size_t> standing_;  ///< bottom nodes of the body, by contact unknown
  std::vector<Birth> births_;          ///< of the step
};

}  // namespace dccast::mechanics
