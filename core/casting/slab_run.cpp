#include "core/casting/slab_run.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>

#include "core/casting/monitors.hpp"
#include "core/casting/validity/motion.hpp"
#include "core/mesh/gmsh_reader.hpp"

namespace dccast::casting {

namespace {

constexpr double same_time = 1e-9;  // [s]

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double largest(const mesh::Mesh2D& mesh, std::size_t coordinate) {
  double value = 0.0;
  for (int n = 0; n < mesh.nodes(); ++n) value = std::max(value, mesh.point(n)[coordinate]);
  return value;
}

mesh::Mesh2D imported_mesh(const Case& c) {
  Faults faults;
  auto mesh = mesh::read_gmsh<2>(c.section.file, c.section.element, faults);
  if (!mesh) throw InvalidCase(faults);
  return std::move(*mesh);
}

}  // namespace

RunMesh::RunMesh(const Case& c) : grows_(c.section.growth) {
  if (c.section.file.empty()) slab_.emplace(c.section);
  else imported_ = imported_mesh(c);
}

SlabRun::SlabRun(const Case& c)
    : case_(c),
      schedule_(c),
      control_(c.time.minimum_step),
      mesh_(c),
      heat_(c, thermal::make_heat_forms(mesh_.mesh(), c.section.kind)),
      mechanics_(mechanics::make_mechanics_forms(c.section.element, c.section.kind),
                 material::MechanicalProperties(c.alloy), c.mechanics.options),
      initial_level_(largest(mesh_.mesh(), 1)),
      face_length_(c.section.kind == mesh::SectionKind::axisymmetric ? largest(mesh_.mesh(), 0)
                                                                     : 1.0),
      validity_(c) {
  mechanics_.set_mesh(mesh_.mesh());
  state_.time = schedule_.begin();
  state_.next_frame = state_.time;
  state_.step_limit = control_.limit();
  state_.heat = heat_.initial_field(
      state_.time,
      c.thermal.initial_temperature.value_or(schedule_.casting_temperature(state_.time, 0.0)));
  state_.slab = mechanics_.initial_state();
  if (mesh_.built_in()) state_.row_heights = mesh_.built_in()->row_heights();
}

void SlabRun::restore(const RunState& state) {
  state_ = state;
  control_.restore(state.step_limit);
  if (mesh_.built_in()) mesh_.slab().restore(state.row_heights);
  heat_.update_mesh();
  mechanics_.set_mesh(mesh_.mesh());
}

bool SlabRun::finished() const {
  return state_.time >= schedule_.end() - same_time;
}

double SlabRun::metal_level() const {
  return mesh_.grows() ? initial_level_ + state_.cast_length : initial_level_;
}

int SlabRun::growth_row() const {
  return mesh_.built_in() ? mesh_.built_in()->nodes_per_row() : 0;
}

results::StepReport SlabRun::advance() {
  const double start = thread_seconds();
  const RunState saved = state_;
  for (int failed = 0;; ++failed) {
    const double dt = control_.choose(schedule_.step_at(state_.time));
    const Attempt tried = attempt(dt);
    if (tried.converged) {
      control_.accepted();
      state_.step_limit = control_.limit();
      ++state_.step;
      state_.solver_seconds += thread_seconds() - start;
      return report(tried, failed);
    }
    const bool smaller = control_.rejected(dt);
    const double limit = control_.limit();
    restore(saved);
    control_.restore(limit);
    if (smaller) continue;
    char text[256];
    std::snprintf(text, sizeof text,
                  "the %s step at t = %.6g s did not converge, and the time step cannot be cut below "
                  "%.3g s (time.minimum_step)",
                  tried.why.c_str(), state_.time, case_.time.minimum_step);
    const auto& history = tried.why == "heat" ? tried.heat.residual_history
                                              : tried.mechanics.residual_history;
    throw SolveFailed(text, state_.time, dt, history);
  }
}

Attempt SlabRun::attempt(double dt) {
  Attempt tried;
  tried.time_step = dt;
  const double end = state_.time + dt;
  // The mechanics begins at its start time with the shell of that moment.
  const bool moves = case_.mechanics.enabled && state_.time >= case_.mechanics.start - same_time;
  if (moves && !state_.slab.started) mechanics_.start(state_.slab, state_.heat.temperature);

  const double length = schedule_.cast_length(state_.cast_length, state_.time, dt);
  std::optional<thermal::MetalEntry> entry;
  grow(length, schedule_.casting_temperature(end, length), entry);
  state_.cast_length = length;
  state_.time = std::abs(end) < same_time ? 0.0 : end;

  const thermal::HeatField heat_n = state_.heat;
  const mechanics::SlabState<2> slab_n = state_.slab;
  const int rounds = moves && case_.coupling.gap_feedback ? case_.coupling.iterations : 1;
  for (int round = 0; round < rounds; ++round) {
    if (!step_heat(tried, heat_n, entry)) return tried;
    if (moves && !step_mechanics(tried, slab_n)) return tried;
  }
  tried.converged = true;
  return tried;
}

bool SlabRun::grow(double length, double temperature, std::optional<thermal::MetalEntry>& entry) {
  const double level = initial_level_ + length;
  if (!mesh_.grows() || level <= mesh_.slab().level()) return false;
  mesh::SlabMesh2D& slab = mesh_.slab();
  const int first_moved = slab.elements_per_row() * (slab.rows() - 1);
  slab.grow_to(level);
  entry = heat_.follow_growth(state_.heat, slab.nodes_per_row(), temperature);
  mechanics_.follow_growth(state_.slab, slab.mesh(), slab.nodes_per_row(), first_moved);
  state_.row_heights = slab.row_heights();
  return true;
}

std::vector<double> SlabRun::bottom_gap() const {
  std::vector<double> gap;
  if (!case_.coupling.gap_feedback || !state_.slab.started) return gap;
  for (int n : mechanics_.bottom_nodes()) {
    gap.push_back(std::max(0.0, state_.slab.displacement[2 * std::size_t(n) + 1]));
  }
  return gap;
}

bool SlabRun::step_heat(Attempt& tried, const thermal::HeatField& from,
                        const std::optional<thermal::MetalEntry>& entry) {
  const std::vector<double> gap = bottom_gap();
  thermal::HeatStepInput input;
  input.time = state_.time;
  input.time_step = tried.time_step;
  input.metal_level = metal_level();
  input.casting_temperature = schedule_.casting_temperature(state_.time, state_.cast_length);
  input.water_flow = schedule_.water_flow(state_.time, state_.cast_length);
  input.bottom_gap = gap;
  input.entry = entry;
  state_.heat = from;
  tried.heat = heat_.step(state_.heat, input);
  if (!tried.heat.converged) tried.why = "heat";
  return tried.heat.converged;
}

bool SlabRun::step_mechanics(Attempt& tried, const mechanics::SlabState<2>& from) {
  state_.slab = from;
  mechanics::SlabStepInput input;
  input.temperature = state_.heat.temperature;
  input.time_step = tried.time_step;
  input.metal_level = metal_level();
  const mechanics::StepOutcome outcome = mechanics_.step(state_.slab, input);
  const mechanics::StepOutcome before = tried.mechanics;
  tried.mechanics = outcome;
  tried.mechanics.iterations += before.iterations;
  tried.mechanics.factorizations += before.factorizations;
  tried.mechanics.solves += before.solves;
  tried.mechanics.contact_changes += before.contact_changes;
  if (!outcome.converged) tried.why = "mechanical";
  return outcome.converged;
}

results::StepReport SlabRun::report(const Attempt& accepted, int failed_attempts) {
  results::StepReport r;
  r.step = state_.step;
  r.time = state_.time;
  r.time_step = accepted.time_step;
  r.cast_length = state_.cast_length;
  r.iterations = accepted.mechanics.iterations;
  r.heat_iterations = accepted.heat.iterations;
  r.contact_changes = accepted.mechanics.contact_changes;
  r.factorizations = accepted.mechanics.factorizations + accepted.heat.factorizations;
  r.solves = accepted.mechanics.solves + accepted.heat.solves;
  r.failed_attempts = failed_attempts;
  r.constitutive_residual = accepted.mechanics.constitutive_residual;
  r.energy_balance_error = accepted.heat.balance.error;
  r.wall_heat_flux = (accepted.heat.balance.side + accepted.heat.balance.bottom) /
                     (accepted.time_step * face_length_);
  if (state_.slab.started) report_mechanics(r);
  const double level = metal_level();
  r.sump_depth = sump_depth(mesh(), state_.heat.temperature, level, case_.alloy.coherency);
  r.mould_exit_temperature =
      side_temperature(mesh(), state_.heat.temperature, level - case_.cooling.water.from);
  for (const Monitor& monitor : case_.monitors) {
    const auto place = locate(mesh(), monitor.x, monitor.y);
    // A monitor above the metal level is not poured yet: it has no displacement.
    r.monitor_displacement.push_back(
        place ? displacement_at(mesh(), *place, state_.slab.displacement)
              : std::array<double, 2>{std::nan(""), std::nan("")});
  }
  r.nodes = mesh().nodes();
  r.elements = mesh().elements();
  r.solver_seconds = state_.solver_seconds;
  r.progress = (state_.time - schedule_.begin()) / (schedule_.end() - schedule_.begin());
  return r;
}

void SlabRun::report_mechanics(results::StepReport& r) {
  const mechanics::SlabChecks& checks = mechanics_.checks();
  r.equilibrium_residual = checks.equilibrium_residual;
  r.complementarity_error = checks.complementarity_error;
  r.bottom_reaction = checks.bottom_reaction / face_length_;
  r.weight = checks.weight / face_length_;
  r.contact_length = checks.contact_length;
  r.liquid_pressure_error = checks.liquid_pressure_error;
  const SolidMotion motion =
      validity_.judge({state_.time, mesh(), state_.slab, state_.heat.temperature,
                       mesh().elements() - growing_elements(), liquid_pressure_error()},
                      state_.validity);
  r.maximum_rotation = motion.rotation;
  r.bottom_slip = motion.slip;
  r.beyond_validity = state_.validity.lost.has_value();
}

Extreme SlabRun::liquid_pressure_error() const {
  const mechanics::SlabChecks& checks = mechanics_.checks();
  if (checks.worst_liquid < 0) return {};
  return {checks.liquid_pressure_error, centroid(mesh(), checks.worst_liquid)};
}

/// Elements of the row that stretches with the metal level; none once the metal stands.
int SlabRun::growing_elements() const {
  return mesh_.grows() ? mesh().elements() / mesh_.built_in()->rows() : 0;
}

}  // namespace dccast::casting
