#include "core/thermal/heat_solver.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "core/thermal/growth.hpp"

namespace dccast::thermal {
namespace {

using material::ThermalState;

/// D of a node within an isothermal change, relative to the largest D of the alloy [1]: zero in
/// theory, small enough here that c/D exceeds every other entry of its row by orders of magnitude.
constexpr double vanishing_slope = 1e-14;
/// Diagonal entry of a node whose temperature is given; the other entries are of order one.
constexpr double held_diagonal = 1e30;
/// The line search compares with the largest of this many previous residuals: passing a kink often
/// increases the residual once.
constexpr std::size_t remembered_residuals = 3;
/// If V/dt + dq/dH is below this share of V/dt [1], it is not used as a divisor.
constexpr double smallest_capacity = 0.05;
constexpr double smallest_damping = 1.0 / 64.0;
/// The factorisation is kept while the residual decreases by more than this ratio [1].
constexpr double keep_factor_while_falling_by = 50.0;
/// Relative tolerance of conjugate gradients [1]. Newton's method removes what is left: with 1e-8,
/// in double precision, it needs a fifth fewer iterations, which cost a tenth more in all.
constexpr double gradients_tolerance = 1e-4;
constexpr int most_gradients = 200;

double sum_of_products(const std::vector<double>& a, const std::vector<double>& b) {
  long double sum = 0.0L;  // totals are 1e4 times larger than the heat exchanged in a small step
  for (std::size_t i = 0; i < a.size(); ++i) sum += static_cast<long double>(a[i]) * b[i];
  return static_cast<double>(sum);
}

}  // namespace

HeatSolver::HeatSolver(material::ThermalProperties properties, CoolingSpec cooling,
                       std::unique_ptr<HeatForms> forms, double tolerance, int maximum_iterations)
    : properties_(std::move(properties)),
      cooling_(std::move(cooling)),
      forms_(std::move(forms)),
      tolerance_(tolerance),
      maximum_iterations_(maximum_iterations) {
  forms_->update();
  take_elements();
}

void HeatSolver::update_mesh() {
  if (forms_->update()) take_elements();
}

MetalEntry HeatSolver::follow_growth(HeatField& field, int nodes_per_row, double temperature) {
  bool new_pattern = false;
  const std::size_t first = field.enthalpy.size() - 2 * std::size_t(nodes_per_row);  // that changes
  const double entering = properties_.enthalpy(temperature);
  MetalEntry entry = forms_->follow_growth(nodes_per_row, entering, field.enthalpy, new_pattern);
  entry.superheat = entry.entered * std::max(0.0, 1.0 - properties_.liquidus_enthalpy() / entering);
  if (new_pattern) take_elements();
  refresh(field, first);
  if (!field.wetted.empty()) field.wetted.resize(faces * field.enthalpy.size(), 0.0);
  if (!field.enthalpy_rate.empty()) field.enthalpy_rate.resize(field.enthalpy.size(), 0.0);
  return entry;
}

double HeatSolver::follow_merging(HeatField& field, const mesh::MergedRows& merged) {
  const double before = heat_content(forms_->volume(), field.enthalpy);
  forms_->follow_merging(merged, field.enthalpy);
  take_elements();
  refresh(field);
  if (!field.wetted.empty())
    mesh::take_out_rows(merged, faces * merged.nodes_per_row, field.wetted);
  if (!field.enthalpy_rate.empty())
    mesh::take_out_rows(merged, merged.nodes_per_row, field.enthalpy_rate);
  return std::abs(heat_content(forms_->volume(), field.enthalpy) - before) / std::abs(before);
}

void HeatSolver::take_elements() {
  choose_solver();

  const std::size_t nodes = std::size_t(forms_->nodes());
  for (auto* by_node : {&enthalpy_n_, &enthalpy_, &trial_, &kirchhoff_, &residual_, &capacity_,
                        &from_slope_, &right_, &y_, &stiffness_y_, &direction_}) {
    by_node->assign(nodes, 0.0);
  }

  cooling_.resize(nodes);
  state_.assign(nodes, ThermalState{});
  matrix_.assign(forms_->pattern().entries(), 0.0);

  top_nodes_.clear();
  if (cooling_.spec().top == Top::held) top_nodes_ = forms_->top_nodes();
  held_.assign(nodes, 0);
  for (const int node : top_nodes_) held_[std::size_t(node)] = 1;
}

/// Chooses conjugate gradients with vertical lines where the mesh has these, else a factorisation.
void HeatSolver::choose_solver() {
  lines_.reset();
  if (const auto extrusion = forms_->extrusion())
    lines_ = linalg::LineGradients::of(forms_->pattern(), extrusion->lines);
  if (lines_) return;

  const auto fronts = forms_->fronts();
  solver_.analyze(forms_->pattern(), forms_->geometry(), fronts);
}

double HeatSolver::superheat(const HeatField& field) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < field.enthalpy.size(); ++i)
    sum += forms_->volume()[i] * std::max(0.0, field.enthalpy[i] - properties_.liquidus_enthalpy());
  return sum;
}

HeatField HeatSolver::uniform_field(double temperature) const {
  HeatField field;
  field.enthalpy.assign(std::size_t(forms_->nodes()), properties_.enthalpy(temperature));
  refresh(field);
  return field;
}

void HeatSolver::refresh(HeatField& field, std::size_t first) const {
  field.temperature.resize(field.enthalpy.size());
  field.liquid_fraction.resize(field.enthalpy.size());
  for (std::size_t i = first; i < field.enthalpy.size(); ++i) {
    const ThermalState state = properties_.state(field.enthalpy[i]);
    field.temperature[i] = state.temperature;
    field.liquid_fraction[i] = state.liquid_fraction;
  }
}

void HeatSolver::prepare(const HeatField& field, const HeatStepInput& input) {
  if (field.enthalpy.size() != state_.size()) {
    throw std::logic_error("HeatSolver: the field does not belong to the mesh");
  }
  enthalpy_n_ = field.enthalpy;
  enthalpy_ = field.enthalpy;
  for (std::size_t i = 0; i < field.enthalpy_rate.size(); ++i)
    enthalpy_[i] += input.time_step * field.enthalpy_rate[i];

  const double held = properties_.enthalpy(input.casting_temperature);
  for (const int node : top_nodes_) enthalpy_[std::size_t(node)] = held;

  cooling_.begin_step(*forms_, properties_, field, input);
}

/// Residual of the step at `enthalpy`, with the quantities for the matrix and the convergence test.
void HeatSolver::evaluate(const std::vector<double>& enthalpy, const HeatStepInput& input) {
  const double reference = properties_.kirchhoff(input.casting_temperature);
  for (std::size_t i = 0; i < enthalpy.size(); ++i) {
    state_[i] = properties_.state(enthalpy[i]);
    kirchhoff_[i] = state_[i].kirchhoff - reference;
  }
  cooling_.evaluate(*forms_, state_, input);
  linalg::multiply(forms_->pattern(), forms_->stiffness(), kirchhoff_, residual_);

  const std::vector<double>&volume = forms_->volume(), &flux = cooling_.flux(),
        &flux_derivative = cooling_.flux_derivative();
  residual_sum_ = moved_ = 0.0;
  double magnitude = 0.0;
  for (std::size_t i = 0; i < enthalpy.size(); ++i) {
    const double stored = volume[i] * (enthalpy[i] - enthalpy_n_[i]);
    residual_[i] += stored / input.time_step + flux[i];
    moved_ += std::abs(stored) + input.time_step * std::abs(flux[i]);
    const double conductance =
        forms_->stiffness()[std::size_t(forms_->pattern().diagonal(static_cast<int>(i)))];
    magnitude +=
        (volume[i] + input.time_step * std::abs(flux_derivative[i])) * std::abs(enthalpy[i]) +
        input.time_step * 2.0 * conductance * std::abs(kirchhoff_[i]);
    if (held_[i] == 0) residual_sum_ += std::abs(residual_[i]);
  }
  round_off_ = 2.0 * std::numeric_limits<double>::epsilon() * magnitude;
}

/// Zero once the residual is at the round-off level of its terms.
double HeatSolver::relative_residual(double time_step) const {
  const double left_over = residual_sum_ * time_step;
  if (left_over <= round_off_) return 0.0;
  return left_over / moved_;
}

/// Assembles and factorises the matrix at the present iterate. Returns false if it is not positive
/// definite.
bool HeatSolver::factorize(Slope kind, double time_step) {
  const auto stiffness = forms_->stiffness();

  std::copy(stiffness.begin(), stiffness.end(), matrix_.begin());
  const std::vector<double>&volume = forms_->volume(),
        &flux_derivative = cooling_.flux_derivative();

  const double largest = properties_.largest_diffusivity();
  for (std::size_t i = 0; i < capacity_.size(); ++i) {
    const double storage = volume[i] / time_step, smallest = smallest_capacity * storage;
    const double slope = kind == Slope::largest ? largest : state_[i].kirchhoff_derivative;
    capacity_[i] = storage + flux_derivative[i];

    // Where the capacity is too small to divide by, the direction follows from the slope, or the
    // capacity is bounded.
    from_slope_[i] = 0.0;
    if (capacity_[i] < smallest) {
      const bool conducts = slope > vanishing_slope * largest;
      if (kind == Slope::newton && conducts) {
        from_slope_[i] = 1.0 / slope;
      } else {
        capacity_[i] = smallest;
      }
    }

    matrix_[std::size_t(forms_->pattern().diagonal(static_cast<int>(i)))] +=
        held_[i] != 0 ? held_diagonal : capacity_[i] / std::max(slope, vanishing_slope * largest);
  }

  return lines_ ? lines_->factorize(forms_->pattern(), matrix_, held_) : solver_.factorize(matrix_);
}

/// Returns false if the matrix is not positive definite, or conjugate gradients did not converge.
bool HeatSolver::solve_by_lines() {
  const auto outcome = lines_->solve(right_, y_, {gradients_tolerance, most_gradients});
  return outcome.end == linalg::CgOutcome::End::converged;
}

/// Where the flux decreases with rising temperature (a film-boiling table, a solid surface cooled
/// more strongly than a liquid one), V/dt + dq/dH may be negative. Conduction usually keeps
/// Newton's matrix positive definite; if not, the decreasing part is left out: convergence is
/// slower, the solution is the same.
bool HeatSolver::factorize_newton(double time_step) {
  return factorize(Slope::newton, time_step) || factorize(Slope::newton_bounded, time_step);
}

/// Returns false if the matrix is not positive definite.
bool HeatSolver::newton_direction() {
  for (std::size_t i = 0; i < right_.size(); ++i) right_[i] = held_[i] != 0 ? 0.0 : -residual_[i];

  if (!lines_) {
    solver_.solve(right_, y_);
  } else if (!solve_by_lines()) {
    return false;
  }

  // From y = D dH to the enthalpy, by the equation of the node or, where chosen, by the slope D.
  linalg::multiply(forms_->pattern(), forms_->stiffness(), y_, stiffness_y_);
  for (std::size_t i = 0; i < direction_.size(); ++i) {
    direction_[i] = from_slope_[i] > 0.0 ? y_[i] * from_slope_[i]
                                         : -(residual_[i] + stiffness_y_[i]) / capacity_[i];
    if (held_[i] != 0) direction_[i] = 0.0;
  }
  return true;
}

/// Reduces the step along the direction until the residual is below `reference`. If no step length
/// succeeds, takes the full step and returns false. Leaves residual and states of the new iterate.
bool HeatSolver::line_search(const HeatStepInput& input, double reference) {
  for (double damping = 1.0; damping >= smallest_damping; damping *= 0.5) {
    for (std::size_t i = 0; i < trial_.size(); ++i) {
      trial_[i] = enthalpy_[i] + damping * direction_[i];
    }
    evaluate(trial_, input);
    if (residual_sum_ <= (1.0 - 1e-4 * damping) * reference) {
      enthalpy_.swap(trial_);
      return true;
    }
  }
  return false;
}

/// A step with D at its upper bound everywhere: a contraction, slow but always convergent.
bool HeatSolver::bounded_step(const HeatStepInput& input) {
  evaluate(enthalpy_, input);
  if (!factorize(Slope::largest, input.time_step) || !newton_direction()) return false;
  for (std::size_t i = 0; i < enthalpy_.size(); ++i) enthalpy_[i] += direction_[i];
  evaluate(enthalpy_, input);
  return true;
}

/// Newton's iterations from the state of `prepare`. Returns true if the tolerance is reached.
bool HeatSolver::iterate(const HeatStepInput& input, HeatStepOutcome& outcome) {
  evaluate(enthalpy_, input);
  std::array<double, remembered_residuals> remembered;
  remembered.fill(residual_sum_);
  bool keep_factor = false;

  for (;; ++outcome.iterations) {
    const double residual = relative_residual(input.time_step);
    outcome.residual_history.push_back(residual);
    if (residual <= tolerance_) return true;
    if (outcome.iterations == maximum_iterations_) return false;
    remembered[std::size_t(outcome.iterations) % remembered_residuals] = residual_sum_;

    const double before = residual_sum_;
    if (!keep_factor && !factorize_newton(input.time_step)) return false;
    if (!newton_direction() &&
        !(factorize(Slope::newton_bounded, input.time_step) && newton_direction()))
      return false;
    if (line_search(input, *std::max_element(remembered.begin(), remembered.end()))) {
      keep_factor = !lines_ && residual_sum_ * keep_factor_while_falling_by < before;
    } else if (keep_factor) {  // the factorisation was an old one: repeat with a new one from the
                               // same iterate
      evaluate(enthalpy_, input);
      keep_factor = false;
    } else {  // Newton's direction is not a descent direction
      if (!bounded_step(input)) return false;
      remembered.fill(residual_sum_);
    }
  }
}

HeatStepOutcome HeatSolver::step(HeatField& field, const HeatStepInput& input) {
  HeatStepOutcome outcome;
  outcome.residual_history.reserve(std::size_t(maximum_iterations_) + 1);

  const long factorizations = solver_.factorizations(), solves = solver_.solves();
  prepare(field, input);
  outcome.converged = iterate(input, outcome);

  outcome.factorizations = static_cast<int>(solver_.factorizations() - factorizations);
  outcome.solves = static_cast<int>(solver_.solves() - solves);
  if (!outcome.converged) return outcome;

  outcome.balance = balance(input);
  outcome.face_heat_flux = cooling_.side_power();
  outcome.wall_heat_flux = outcome.face_heat_flux[0] + outcome.face_heat_flux[1];
  outcome.bottom_heat_flux = cooling_.bottom_power();
  outcome.water = cooling_.water();
  outcome.gap_water = cooling_.gap_streams().water;
  outcome.steam_force = cooling_.gap_streams().steam_force;

  // Only a converged step changes the field.
  field.enthalpy = enthalpy_;
  field.enthalpy_rate.resize(state_.size());
  field.temperature.resize(state_.size());
  field.liquid_fraction.resize(state_.size());
  for (std::size_t i = 0; i < state_.size(); ++i) {
    field.enthalpy_rate[i] = (enthalpy_[i] - enthalpy_n_[i]) / input.time_step;
    field.temperature[i] = state_[i].temperature;
    field.liquid_fraction[i] = state_[i].liquid_fraction;
  }

  cooling_.finish_step(*forms_, state_, input, field);
  return outcome;
}

HeatBalance HeatSolver::balance(const HeatStepInput& input) const {
  const std::vector<double>& volume = forms_->volume();
  HeatBalance heat;

  // Growth has changed the volumes: the heat before it is that of the entry.
  const double stored_before =
      input.entry ? input.entry->stored_before : sum_of_products(volume, enthalpy_n_);
  heat.entered = input.entry ? input.entry->entered : 0.0;
  heat.stored = sum_of_products(volume, enthalpy_) - stored_before;

  // The residual at held nodes is the heat that holds them.
  for (const int node : top_nodes_) heat.top += input.time_step * residual_[std::size_t(node)];
  heat.top -= input.time_step * cooling_.level_power();

  heat.side = input.time_step * (cooling_.side_power()[0] + cooling_.side_power()[1]);
  heat.bottom = input.time_step * cooling_.bottom_power();

  const double missing = heat.stored + heat.side + heat.bottom - heat.top - heat.entered;
  // Not corrected for rounding: a check that allows for its own error hides other errors.
  heat.error = moved_ > 0.0 ? std::abs(missing) / moved_ : 0.0;
  return heat;
}

}  // namespace dccast::thermal
