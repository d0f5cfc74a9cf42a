#include "core/mechanics/slab_mechanics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/mechanics/constitutive.hpp"
#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/step_constraints.hpp"
#include "core/mesh/extrusion.hpp"

namespace dccast::mechanics {

namespace {

template <int Dim>
constexpr int up = Dim - 1;

/// From 4 to 32 smallest rows per coarse row the number of iterations grows by a seventh, while the
/// coarse factor shrinks to a hundredth: docs/developers/factorisation.md.
constexpr double rows_per_coarse_row = 32.0;

/// Smallest share of a step that follows the solidification of an element [1]: its moduli, in
/// proportion to it, must not vanish in a step whose end is the moment of solidification.
constexpr double least_share = 1e-3;

/// Mean height of the nodes of an element [m].
template <int Dim>
double centroid_height(const mesh::Mesh<Dim>& mesh, int element) {
  const int* node = mesh.nodes_of(element);
  double sum = 0.0;
  for (int i = 0; i < mesh.nodes_per_element; ++i) sum += mesh.point(node[i])[Dim - 1];
  return sum / mesh.nodes_per_element;
}

/// (node) whether it belongs to a marked element. @param marked  (element)
template <int Dim>
std::vector<char> nodes_of(const mesh::Mesh<Dim>& mesh, const std::vector<char>& marked) {
  std::vector<char> of_marked(std::size_t(mesh.nodes()), 0);
  for (int e = 0; e < mesh.elements(); ++e) {
    if (marked[std::size_t(e)] == 0) continue;
    for (int i = 0; i < mesh.nodes_per_element; ++i) {
      of_marked[std::size_t(mesh.nodes_of(e)[i])] = 1;
    }
  }
  return of_marked;
}

}  // namespace

template <int Dim>
SlabMechanics<Dim>::SlabMechanics(std::unique_ptr<MechanicsForms<Dim>> forms,
                                  material::MechanicalProperties properties, Options options)
    : forms_(std::move(forms)),
      points_(forms_->points()),
      properties_(std::move(properties)),
      options_(std::move(options)) {}

template <int Dim>
void SlabMechanics<Dim>::set_mesh(const Mesh& mesh, int first_moved) {
  const std::size_t elements = std::size_t(mesh.elements());
  const bool is_new =
      elements != forms_->elements() || std::size_t(mesh.nodes()) * Dim != problem_.unknowns();
  mesh_ = &mesh;
  forms_->update(mesh, elements < forms_->elements() ? 0 : std::size_t(first_moved));
  if (is_new)
    new_pattern();
  else
    find_supports();
  melt_.set_mesh(mesh, is_new);
  problem_.forms = forms_.get();
  problem_.pattern = &pattern_;
  problem_.parts = Dim == 3 ? &parts_ : nullptr;
  problem_.exponent = properties_.creep().exponent;
}

template <int Dim>
void SlabMechanics<Dim>::new_pattern() {
  const Stopwatch watch(work_.cost.analysis);
  std::vector<int> unknown;
  unknown.reserve(mesh_->element_node.size() * Dim);
  for (int n : mesh_->element_node) {
    for (int d = 0; d < Dim; ++d) unknown.push_back(n * Dim + d);
  }

  // Growth appends elements, so that the pattern of the known ones is kept.
  const int unknowns = mesh_->nodes() * Dim;
  const bool grown = !element_unknown_.empty() && element_unknown_.size() < unknown.size() &&
                     std::equal(element_unknown_.begin(), element_unknown_.end(), unknown.begin());
  if (grown) {
    pattern_.extend(unknowns, unknown);
  } else {
    pattern_ = linalg::SparsityPattern(unknowns, unknown, mesh_->nodes_per_element * Dim);
  }
  element_unknown_ = std::move(unknown);
  if (Dim == 3) parts_ = ElementParts::of(*mesh_);

  // Fields by element, then by unknown; a step sets their values.
  for (auto* field :
       {&problem_.bulk, &problem_.shear, &problem_.kappa, &problem_.thermal, &problem_.prestress,
        &problem_.volumetric_kappa, &problem_.melt_pressure, &problem_.linear_below}) {
    field->assign(std::size_t(mesh_->elements()), 0.0);
  }
  if (properties_.has_yield_limit()) {
    problem_.yield.assign(std::size_t(mesh_->elements()), 0.0);
    problem_.hardening.assign(std::size_t(mesh_->elements()), 0.0);
  }
  problem_.external_force.assign(std::size_t(unknowns), 0.0);
  problem_.fixed.assign(std::size_t(unknowns), 0);
  problem_.target.assign(std::size_t(unknowns), 0.0);

  find_supports();

  const auto fronts = mesh::edges_to_sweep_from(*mesh_, Dim);
  choose_solver();
  work_.resize(pattern_, Dim == 2 ? linalg::Geometry::plane : linalg::Geometry::solid, fronts);
}

/// Chooses a factorisation, or the two-grid solver if the factor would be too large. Algorithms
/// other than newton solve many times with one matrix and to full accuracy, which only a
/// factorisation does well.
template <int Dim>
void SlabMechanics<Dim>::choose_solver() {
  work_.two_grid.reset();
  if constexpr (Dim == 3) {
    if (options_.algorithm != Algorithm::newton) return;
    if (pattern_.unknowns() < options_.two_grids_from_unknowns) return;
    const auto extrusion = mesh::extrusion_of(*mesh_);
    if (!extrusion) return;
    work_.two_grid = std::make_unique<linalg::TwoGrid<3>>();
    work_.two_grid->analyze(*extrusion, rows_per_coarse_row);
  }
}

/// Also needed after stretching: the tributary areas of a node on its sides determine its mean
/// normal.
template <int Dim>
void SlabMechanics<Dim>::find_supports() {
  supports_.find(*mesh_, *forms_);
  forms_->set_frames(supports_.frames());
}

template <int Dim>
void SlabMechanics<Dim>::set_initial_gap(std::vector<double> gap) {
  supports_.set_initial_gap(std::move(gap));
}

template <int Dim>
double SlabMechanics<Dim>::bottom_gap(const State& state, std::size_t place) const {
  return supports_.bottom_gap(place, supports_.by_unknown(state.displacement));
}

template <int Dim>
auto SlabMechanics<Dim>::initial_state() const -> State {
  State state;
  const std::size_t all_points = std::size_t(mesh_->elements()) * points_;
  state.displacement.assign(std::size_t(mesh_->nodes()) * Dim, 0.0);
  state.solid.assign(std::size_t(mesh_->elements()), 0);
  state.carries.assign(std::size_t(mesh_->elements()), 0);
  state.inelastic.resize(all_points);
  state.viscoplastic.resize(all_points);
  if (properties_.has_yield_limit()) state.hardened.assign(all_points, 0.0);
  state.deviator.resize(all_points);
  state.pressure.assign(all_points, 0.0);
  state.contact = supports_.initial_contact();
  state.leaning.assign(state.displacement.size(), 1);
  state.reaction.assign(bottom_nodes().size(), 0.0);
  return state;
}

template <int Dim>
void SlabMechanics<Dim>::start(State& state, std::span<const double> temperature) const {
  state.started = true;
  for (int e = 0; e < mesh_->elements(); ++e) {
    const bool at_once = options_.liquid == Liquid::solid;
    const bool solid = at_once || temperature[std::size_t(e)] < properties_.coherency();
    state.solid[std::size_t(e)] = solid ? 1 : 0;
  }
  state.carries = melt_is_outside() ? melt_.carrying(state.solid) : state.solid;

  for (int e = 0; e < mesh_->elements(); ++e) {
    if (state.carries[std::size_t(e)] == 0) continue;
    const double t = temperature[std::size_t(e)];
    for (std::size_t q = 0; q < points_; ++q) {
      state.inelastic[std::size_t(e) * points_ + q].add_identity(-properties_.thermal_stretch(t));
    }
  }
}

/// A solid element uses its rotation at the start of the step. Neglecting the rotation during the
/// step causes a strain of half its square. Liquid elements are not rotated: their pressure, in
/// axes of an earlier step, would load their neighbours, and the liquid has no stiffness to resist.
template <int Dim>
void SlabMechanics<Dim>::set_rotations(std::span<const double> displacement,
                                       std::span<const char> solid) {
  if (options_.kinematics == Kinematics::corotational) forms_->set_rotations(displacement, solid);
}

/// The moment at which an element solidifies, with its mean temperature linear in time. One that
/// has been coherent before joins at its own temperature, at the start of the step.
template <int Dim>
auto SlabMechanics<Dim>::birth_of(std::size_t e, const SlabStepInput& input) const -> Birth {
  const double end = input.element_temperature[e];
  if (options_.liquid == Liquid::solid) return {e, end, 1.0};

  Birth birth{e, properties_.coherency(), 1.0};
  if (input.element_temperature_n.empty()) return birth;
  const double start = input.element_temperature_n[e];
  if (start <= birth.temperature)
    birth.temperature = start;
  else
    birth.share = std::max(least_share, (birth.temperature - end) / (start - end));
  return birth;
}

/// Only what follows the solidification strains an element. With displacements linear in time that
/// is `share` of the strain of the step, so that the law of the metal holds with moduli and
/// hardening times `share` for strains counted from the start of the step. Stress begins at minus
/// the metallostatic pressure; thermal strain counts in full. Creep lasts for `share` of the step:
/// its factor in the law, mu dt kappa, is already the smaller one.
template <int Dim>
void SlabMechanics<Dim>::set_newborn(const Birth& birth) {
  const std::size_t e = birth.element;
  problem_.bulk[e] *= birth.share;
  problem_.shear[e] *= birth.share;
  problem_.thermal[e] =
      (problem_.thermal[e] - properties_.thermal_stretch(birth.temperature)) / birth.share;
  problem_.prestress[e] = -problem_.melt_pressure[e];
  if (properties_.has_yield_limit()) problem_.hardening[e] *= birth.share;
}

/// Sets the reference strain such that the stress at the end of the step is that of metal at this
/// displacement and temperature, for the steps that follow.
/// @param u  displacement at the end of the step, by unknown [m]
template <int Dim>
void SlabMechanics<Dim>::complete_newborn(State& state, const Birth& birth,
                                          std::span<const double> u) const {
  const std::size_t e = birth.element;
  const double shear = problem_.shear[e] / birth.share, bulk = problem_.bulk[e] / birth.share;
  const double thermal =
      properties_.thermal_stretch(birth.temperature) + birth.share * problem_.thermal[e];

  const auto strains = forms_->strains(e, u);
  for (std::size_t q = 0; q < points_; ++q) {
    const std::size_t i = e * points_ + q;
    state.inelastic[i] = strains[q];
    state.inelastic[i].add(-0.5 / shear, state.deviator[i]);
    state.inelastic[i].add_identity(-state.pressure[i] / (3.0 * bulk) - thermal);

    for (double& strain : state.viscoplastic[i].value) strain *= birth.share;
    if (!state.hardened.empty()) state.hardened[i] *= birth.share;
  }
}

/// Resets the history: the element is stress-free at the strain of the start of the step.
template <int Dim>
void SlabMechanics<Dim>::forget_history(State& state, std::size_t e) const {
  const auto strains = forms_->strains(e, displacement_);
  for (std::size_t q = 0; q < points_; ++q) {
    const std::size_t i = e * points_ + q;
    state.inelastic[i] = strains[q];
    state.viscoplastic[i] = {};
    if (!state.hardened.empty()) state.hardened[i] = 0.0;
    state.deviator[i] = {};
  }
}

/// Metallostatic pressure at the centre of an element.
template <int Dim>
double SlabMechanics<Dim>::melt_pressure(int e, double level) const {
  return properties_.liquid_density() * options_.gravity *
         std::max(0.0, level - centroid_height(*mesh_, e));
}

template <int Dim>
void SlabMechanics<Dim>::set_phases(State& state, const SlabStepInput& input) {
  const bool at_once = options_.liquid == Liquid::solid;
  for (std::size_t e = 0; e < state.solid.size(); ++e) {
    const bool solid = at_once || input.element_temperature[e] < properties_.coherency();
    state.solid[e] = solid ? 1 : 0;
  }
  const std::vector<char> before =
      std::exchange(state.carries, melt_is_outside() ? melt_.carrying(state.solid) : state.solid);

  set_rotations(displacement_, state.carries);
  births_.clear();
  for (std::size_t e = 0; e < before.size(); ++e) {
    if (state.carries[e] == before[e]) continue;
    forget_history(state, e);
    if (state.carries[e] != 0) births_.push_back(birth_of(e, input));
  }
  of_body_ = nodes_of(*mesh_, state.carries);
}

template <int Dim>
void SlabMechanics<Dim>::set_materials(const State& state, const SlabStepInput& input) {
  // The paper's weak material, eq. (38). Melt that is no part of the body has some moduli, for laws
  // that divide by them.
  const double at = properties_.liquidus();
  const double mu_liquid =
      std::pow(options_.liquid_epsilon, options_.liquid_delta) * properties_.shear_modulus(at);
  const double lambda_solid =
      properties_.bulk_modulus(at) - 2.0 / 3.0 * properties_.shear_modulus(at);
  const double lambda_liquid =
      std::pow(options_.liquid_epsilon, options_.liquid_beta) * lambda_solid;
  for (int e = 0; e < mesh_->elements(); ++e) {
    const std::size_t i = std::size_t(e);
    if (state.carries[i] != 0) {
      set_solid(e, input.element_temperature[i], input.metal_level);
      continue;
    }

    problem_.bulk[i] = lambda_liquid + 2.0 / 3.0 * mu_liquid;
    problem_.shear[i] = mu_liquid;
    problem_.kappa[i] = problem_.volumetric_kappa[i] = 0.0;
    problem_.thermal[i] = 0.0;
    problem_.prestress[i] = 0.0;
    if (properties_.has_yield_limit()) {
      problem_.yield[i] = std::numeric_limits<double>::infinity();
      problem_.hardening[i] = 0.0;
    }
  }
  for (const Birth& birth : births_) set_newborn(birth);
}

/// Material of an element that carries stress. @param at  its temperature [°C]
template <int Dim>
void SlabMechanics<Dim>::set_solid(int e, double at, double metal_level) {
  const std::size_t i = std::size_t(e);
  const material::CreepFactors creep = properties_.creep_factors(at);
  problem_.bulk[i] = properties_.bulk_modulus(at);
  problem_.shear[i] = properties_.shear_modulus(at);
  problem_.kappa[i] = creep.deviatoric;
  problem_.volumetric_kappa[i] = creep.volumetric;
  problem_.linear_below[i] = creep.linear_below;
  problem_.melt_pressure[i] = melt_pressure(e, metal_level);
  problem_.thermal[i] = properties_.thermal_stretch(at);
  problem_.prestress[i] = 0.0;

  if (!properties_.has_yield_limit()) return;
  const material::YieldLimit limit = properties_.yield_limit(at);
  problem_.yield[i] = limit.norm;
  problem_.hardening[i] = limit.hardening;
}

template <int Dim>
template <class Counts>
std::vector<double> SlabMechanics<Dim>::specific_weights(const State& state,
                                                         std::span<const double> temperature,
                                                         const Counts& counts) const {
  std::vector<double> specific_weight(std::size_t(mesh_->elements()), 0.0);
  for (std::size_t e = 0; e < specific_weight.size(); ++e) {
    if (!counts(e)) continue;
    const double density =
        state.solid[e] != 0 ? properties_.density(temperature[e]) : properties_.liquid_density();
    specific_weight[e] = density * options_.gravity;
  }
  return specific_weight;
}

template <int Dim>
double SlabMechanics<Dim>::whole_weight(const State& state,
                                        std::span<const double> temperature) const {
  std::vector<double> unused(problem_.unknowns());
  return forms_->subtract_weight(
      specific_weights(state, temperature, [](std::size_t) { return true; }), unused);
}

template <int Dim>
void SlabMechanics<Dim>::set_loads(const State& state, const SlabStepInput& input) {
  auto& force = problem_.external_force;
  std::fill(force.begin(), force.end(), 0.0);
  const auto of_body = [&](std::size_t e) { return !melt_is_outside() || state.carries[e] != 0; };
  problem_.weight =
      forms_->subtract_weight(specific_weights(state, input.element_temperature, of_body), force);
  if (!melt_is_outside()) return;
  problem_.weight += melt_.press(*forms_, state.carries, input.metal_level,
                                 properties_.liquid_density() * options_.gravity, force);
}

template <int Dim>
StepOutcome SlabMechanics<Dim>::step(State& state, const SlabStepInput& input) {
  StepUnknowns<Dim> unknowns = begin(state, input);
  const StepOutcome outcome = solve_step(problem_, options_, work_, unknowns);
  if (outcome.converged) finish(state, unknowns, outcome);
  return outcome;
}

template <int Dim>
StepUnknowns<Dim> SlabMechanics<Dim>::begin(State& state, const SlabStepInput& input) {
  displacement_ = supports_.by_unknown(state.displacement);
  set_phases(state, input);
  set_materials(state, input);
  set_loads(state, input);
  StepUnknowns<Dim> unknowns{displacement_, {}, {}, state.deviator};
  set_supports(state, input, unknowns);
  forms_->set_taking_part(melt_is_outside() ? state.carries : std::vector<char>());
  problem_.dt = input.time_step;
  problem_.inelastic = state.inelastic;
  problem_.hardened = state.hardened;
  return unknowns;
}

template <int Dim>
std::vector<double> SlabMechanics<Dim>::off_block(State state, const SlabStepInput& input) {
  StepUnknowns<Dim> unknowns = begin(state, input);
  const bool is_cold = std::ranges::all_of(state.solid, [](char solid) { return solid != 0; });
  if (!is_cold || !supports_.stands_upright()) return {};

  // Nothing acts and nothing touches the slab but its planes of symmetry.
  std::ranges::fill(problem_.external_force, 0.0);
  std::ranges::fill(problem_.fixed, 0);
  std::ranges::fill(problem_.target, 0.0);
  problem_.spring.clear();
  unknowns.contact.clear();
  const std::vector<char> nothing_stands(of_body_.size(), 0);
  supports_.place_on_block(problem_, true, nothing_stands);

  // One node at rest takes the vertical motion.
  const std::size_t at_rest = std::size_t(bottom_nodes().front() * Dim + up<Dim>);
  problem_.fixed[at_rest] = 1;
  problem_.target[at_rest] = displacement_[at_rest];

  problem_.dt = 0.0;
  Options options = options_;
  options.algorithm = Algorithm::newton;
  if (!solve_step(problem_, options, work_, unknowns).converged) return {};
  return supports_.by_coordinate(std::move(unknowns.displacement));
}

template <int Dim>
void SlabMechanics<Dim>::set_supports(State& state, const SlabStepInput& input,
                                      StepUnknowns<Dim>& unknowns) {
  std::fill(problem_.fixed.begin(), problem_.fixed.end(), 0);
  std::fill(problem_.target.begin(), problem_.target.end(), 0.0);

  // Without the melt nothing resists where its nodes move: they stay and follow later.
  std::vector<char> unknown_nodes(of_body_.size(), 1);
  if (melt_is_outside()) {
    unknown_nodes = of_body_;
    for (std::size_t i = 0; i < problem_.unknowns(); ++i) {
      if (of_body_[i / std::size_t(Dim)] != 0) continue;
      problem_.fixed[i] = 1;
      problem_.target[i] = displacement_[i];
    }
  }

  standing_ = supports_.place_on_block(problem_, options_.contact, unknown_nodes);
  if (options_.contact) {
    for (const std::size_t i : standing_) {
      unknowns.contact.push_back(state.contact[i]);
      if (!state.contact_multiplier.empty())
        unknowns.contact_multiplier.push_back(state.contact_multiplier[i]);
    }
  }
  supports_.hold_sides(problem_, options_, of_body_, input.node_temperature, properties_.shell(),
                       input.mould_level.value_or(input.metal_level) - options_.mould_length,
                       displacement_, state.leaning, unknowns.contact);
  if (!unknowns.contact_multiplier.empty())
    unknowns.contact_multiplier.resize(problem_.contact.size(), 0.0);
}

/// Evaluates the solution of an algorithm that uses another law with the law of the step problem.
template <int Dim>
ForceScales SlabMechanics<Dim>::evaluate_end(StepUnknowns<Dim>& unknowns) {
  Equilibrium<Dim> equilibrium(problem_);
  const double round_off = round_off_force(problem_);
  const double acting =
      equilibrium.residual(unknowns.displacement, work_.residual, return_map_law(problem_));
  unknowns.deviator = equilibrium.deviators();
  return {std::max(acting, least_acting_force(problem_, round_off, options_.tolerance)), round_off};
}

template <int Dim>
void SlabMechanics<Dim>::finish(State& state, StepUnknowns<Dim>& unknowns,
                                const StepOutcome& outcome) {
  check_balance(unknowns, outcome.forces_at_end ? *outcome.forces_at_end : evaluate_end(unknowns));
  state.deviator = std::move(unknowns.deviator);
  for (int e = 0; e < mesh_->elements(); ++e) {
    const std::size_t first = std::size_t(e) * points_;
    const bool outside = melt_is_outside() && state.carries[std::size_t(e)] == 0;
    if (outside) std::fill_n(state.deviator.begin() + long(first), points_, Tensor{});
    std::fill_n(state.pressure.begin() + long(first), points_,
                outside ? -melt_pressure(e, melt_.surface(e))
                        : mean_normal_stress(problem_, e, unknowns.displacement));
  }
  accumulate_viscoplastic_strain(problem_, state.deviator, unknowns.displacement, state.hardened,
                                 state.inelastic, state.viscoplastic);
  for (const Birth& birth : births_) complete_newborn(state, birth, unknowns.displacement);
  store_supports(state, unknowns);

  if (melt_is_outside()) {
    std::vector<char> held(problem_.unknowns(), 0);
    for (std::size_t i = 0; i < held.size(); ++i) held[i] = of_body_[i / std::size_t(Dim)];
    supports_.hold_melt(held);
    melt_.follow(*forms_, state.carries, pattern_, held, unknowns.displacement);
  }
  state.displacement = supports_.by_coordinate(std::move(unknowns.displacement));
}

template <int Dim>
void SlabMechanics<Dim>::check_balance(const StepUnknowns<Dim>& unknowns,
                                       const ForceScales& forces) {
  std::vector<char> contact = unknowns.contact;
  StepConstraints<Dim> constraints(problem_, contact, forces.round_off);
  checks_.weight = problem_.weight;
  checks_.equilibrium_residual = constraints.norm_of_free(work_.residual) / forces.acting;
  checks_.complementarity_error =
      constraints.complementarity_error(unknowns.displacement, work_.residual);
}

/// Stores contact state and reactions of block and mould. Melt that touches the block is in contact
/// with it.
template <int Dim>
void SlabMechanics<Dim>::store_supports(State& state, StepUnknowns<Dim>& unknowns) {
  std::ranges::fill(state.reaction, 0.0);
  std::vector<char> contact(bottom_nodes().size(), 1);
  if (options_.contact) {
    for (std::size_t i = 0; i < contact.size(); ++i)
      contact[i] = supports_.is_on_block(i, unknowns.displacement) ? 1 : 0;
  }
  std::vector<double> multiplier(unknowns.contact_multiplier.empty() ? 0 : contact.size(), 0.0);

  for (std::size_t k = 0; k < standing_.size(); ++k) {
    const std::size_t i = standing_[k];
    if (options_.contact) contact[i] = unknowns.contact[k];
    if (!multiplier.empty()) multiplier[i] = unknowns.contact_multiplier[k];
    if (contact[i] != 0)
      state.reaction[i] = work_.residual[std::size_t(bottom_nodes()[i] * Dim + up<Dim>)];
  }

  checks_.bottom_reaction = checks_.contact_length = checks_.wall_reaction = 0.0;
  for (std::size_t i = 0; i < contact.size(); ++i) {
    checks_.bottom_reaction += state.reaction[i] * supports_.upward()[i];
    if (contact[i] != 0) checks_.contact_length += supports_.bottom_measure()[i];
  }
  for (std::size_t i = 0; i < state.leaning.size(); ++i)
    state.leaning[i] = of_body_[i / std::size_t(Dim)] == 0 ? 1 : 0;
  for (std::size_t i = problem_.carrying(); i < problem_.contact.size(); ++i) {
    if (unknowns.contact[i] == 0) continue;
    checks_.wall_reaction += problem_.along_gap(i, work_.residual);
    state.leaning[std::size_t(problem_.contact[i])] = 1;
  }

  if (options_.contact) state.contact = std::move(contact);
  state.contact_multiplier = std::move(multiplier);
}

template class SlabMechanics<2>;
template class SlabMechanics<3>;

}  // namespace dccast::mechanics
