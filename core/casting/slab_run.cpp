#include "core/casting/slab_run.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <utility>

#include "core/base/stopwatch.hpp"
#include "core/casting/case/judged_monitor.hpp"
#include "core/casting/findings/motion.hpp"
#include "core/casting/run_shape.hpp"
#include "core/mesh/bottom_normals.hpp"

namespace dccast::casting {

namespace {

/// Processor time of this thread, or of all threads of the process [s].
double seconds_of(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

template <int Dim>
std::unique_ptr<mechanics::MechanicsForms<Dim>> forms_of(const mesh::SectionSpec& section) {
  if constexpr (Dim == 2)
    return mechanics::make_mechanics_forms(section.element, section.kind);
  else
    return mechanics::make_solid_forms(section.element);
}

/// The mould ends where the water begins.
mechanics::Options options_of(const Case& c) {
  mechanics::Options options = c.mechanics.options;
  options.mould_length = c.cooling.water.from;
  return options;
}

/// (bottom node) initial distance of a block with a profile below the slab [m]; empty for a flat
/// block.
template <int Dim>
std::vector<double> initial_gap(const thermal::BottomBlock& block, const mesh::Mesh<Dim>& mesh,
                                const std::vector<int>& bottom_nodes) {
  std::vector<double> gap;
  if (block.profile_x.empty() && block.profile_y.empty()) return gap;
  for (const int n : bottom_nodes) {
    const double* at = mesh.point(n);
    double depth = block.profile_x.empty() ? 0.0 : block.profile_x(at[0]);
    if (Dim == 3 && !block.profile_y.empty()) depth += block.profile_y(at[1]);
    gap.push_back(depth);
  }
  return gap;
}

template <int Dim>
BlockSurface<Dim> surface_of_block(const thermal::BottomBlock& block,
                                   const mesh::Mesh<Dim>& heat_mesh) {
  BlockSurface<Dim> surface;
  surface.nodes = mesh::patch_nodes(heat_mesh, mesh::PatchKind::bottom);
  surface.normal = mesh::inward_normals(heat_mesh, surface.nodes);
  surface.initial_gap = initial_gap(block, heat_mesh, surface.nodes);
  return surface;
}

}  // namespace

template <int Dim>
SlabRun<Dim>::SlabRun(const Case& c, int threads)
    : case_(c),
      team_(Dim == 3 ? threads : 1),
      schedule_(c),
      control_(c.time.minimum_step),
      mesh_(c),
      heat_(c, thermal::make_heat_forms(mesh_.heat_mesh(), c.section.kind)),
      mechanics_(forms_of<Dim>(c.section), material::MechanicalProperties(c.alloy), options_of(c)),
      face_length_(c.section.kind == mesh::SectionKind::axisymmetric ? mesh_.mesh().largest(0)
                                                                     : 1.0),
      block_(surface_of_block(c.cooling.bottom_block, mesh_.heat_mesh())),
      meter_(case_) {
  mechanics_.set_mesh(mesh_.mesh());
  mechanics_.set_initial_gap(
      initial_gap(c.cooling.bottom_block, mesh_.mesh(), mechanics_.bottom_nodes()));

  state_.time = schedule_.begin();
  state_.next_frame = state_.time;
  state_.step_limit = control_.limit();

  state_.heat = heat_.initial_field(state_.time, schedule_.casting_temperature(state_.time, 0.0));
  state_.slab = mechanics_.initial_state();
  state_.superheat = heat_.superheat(state_.heat);
  if (mesh_.in_rows()) state_.row_heights = mesh_.in_rows()->row_heights();
  state_.findings.raised = findings_of_case(c);
}

/// Processor time of all threads of the run [s].
template <int Dim>
double SlabRun<Dim>::processor_seconds() const {
  return seconds_of(CLOCK_THREAD_CPUTIME_ID) + team_.processor_seconds();
}

template <int Dim>
void SlabRun<Dim>::go_back_to(const RunState<Dim>& state) {
  state_ = state;
  control_.restore(state.step_limit);
  if (mesh_.in_rows()) mesh_.slab().restore(state.row_heights);
  heat_.update_mesh();
  mechanics_.set_mesh(mesh_.mesh());
}

template <int Dim>
std::string SlabRun<Dim>::restore(const results::Sections& stored) {
  try {
    const auto state = state_of<Dim>(stored);
    std::string reason = misfit(state, {case_, schedule_, mesh_, mechanics_.points()});
    if (!reason.empty()) return reason;
    if (state.settled_at > 0.0) end_casting(state.settled_at);
    go_back_to(state);
    return reason;
  } catch (const std::out_of_range& error) {
    return std::string("it is incomplete: ") + error.what();
  }
}

template <int Dim>
bool SlabRun<Dim>::finished() const {
  return state_.time >= schedule_.end() - same_time || has_cooled_down();
}

template <int Dim>
void SlabRun<Dim>::end_where_settled(const MonitorReadings& monitors) {
  if (state_.settled_at > 0.0 || schedule_.is_followed()) return;
  state_.curl.add(state_.time, judged_curl(case_, monitors.displacement));
  if (!state_.curl.has_settled(*case_.time.settled, state_.cast_length) ||
      schedule_.changes_after(state_.time, state_.cast_length))
    return;
  state_.settled_at = state_.time;
  end_casting(state_.settled_at);
}

template <int Dim>
void SlabRun<Dim>::end_casting(double time) {
  case_.time.end = time;
  schedule_.end_casting(time);
}

/// Whether all metal is at the temperature of the air, some time after the end of the casting.
template <int Dim>
bool SlabRun<Dim>::has_cooled_down() const {
  constexpr double close = 1.0;  // [K]
  if (state_.time <= schedule_.end_of_casting() + same_time) return false;
  const double air = case_.cooling.ambient_temperature;
  return std::ranges::all_of(state_.heat.temperature,
                             [=](double t) { return std::abs(t - air) <= close; });
}

template <int Dim>
double SlabRun<Dim>::metal_level() const {
  return mesh_.level();
}

template <int Dim>
double SlabRun<Dim>::mould_level() const {
  return mesh_.initial_level() + (mesh_.grows() ? state_.cast_length : 0.0);
}

template <int Dim>
int SlabRun<Dim>::growth_row() const {
  return mesh_.in_rows() ? mesh_.in_rows()->nodes_per_row() : 0;
}

template <int Dim>
bool SlabRun<Dim>::frame_is_due() const {
  return state_.time >= state_.next_frame - same_time || finished();
}

template <int Dim>
results::StepReport SlabRun<Dim>::advance() {
  const Team::Lent lent(&team_);
  const double start = processor_seconds();
  const double process_start = seconds_of(CLOCK_PROCESS_CPUTIME_ID);
  const RunState<Dim> saved = state_;

  for (int failed = 0;; ++failed) {
    const double dt = next_step();
    const Attempt tried = attempt(dt);

    if (tried.converged()) {
      control_.accepted();
      state_.step_limit = control_.limit();
      ++state_.step;

      state_.superheat += tried.superheat;
      state_.level_heat += tried.heat.balance.top;
      state_.solver_seconds += processor_seconds() - start;
      state_.process_seconds += seconds_of(CLOCK_PROCESS_CPUTIME_ID) - process_start;

      MonitorReadings monitors = read_monitors(displacement());
      if (case_.time.settled) end_where_settled(monitors);
      const StepFigures figures = measure(tried, monitors);
      judge(figures);
      return report(tried, failed, figures, std::move(monitors));
    }
    // go_back_to() also restores the limit of the step, which rejected() has just made smaller.
    const bool smaller = control_.rejected(dt);
    const double limit = control_.limit();
    go_back_to(saved);
    control_.restore(limit);
    if (smaller) continue;

    const bool heat = tried.diverged == Diverged::heat;
    char text[256];
    std::snprintf(
        text, sizeof text,
        "the %s step at t = %.6g s did not converge, and the time step cannot be cut below "
        "%.3g s (time.minimum_step)",
        heat ? "heat" : "mechanical", state_.time, case_.time.minimum_step);
    throw SolveFailed(text, state_.time, dt,
                      heat ? tried.heat.residual_history : tried.mechanics.residual_history);
  }
}

template <int Dim>
Attempt SlabRun<Dim>::attempt(double dt) {
  Attempt tried;
  tried.time_step = dt;
  const double end = state_.time + dt;
  // The mechanics begins at its start time with the shell that exists then.
  const bool moves = case_.mechanics.enabled && state_.time >= case_.mechanics.start - same_time;
  if (moves && !state_.slab.started) mechanics_.start(state_.slab, element_temperature());

  const double length = schedule_.cast_length(state_.cast_length, state_.time, dt);
  std::optional<thermal::MetalEntry> entry;
  tried.merge = merge_rows();
  grow(mesh_.level_at(schedule_, end, length), schedule_.casting_temperature(end, length), entry);
  if (entry) tried.superheat = entry->superheat;
  state_.cast_length = length;
  state_.time = std::abs(end) < same_time ? 0.0 : end;

  const int rounds = moves && case_.coupling.gap_feedback ? case_.coupling.iterations : 1;
  const std::vector<double> temperature_n = element_temperature();
  std::optional<StepStart<Dim>> again;
  if (rounds > 1) again = {state_.heat, state_.slab};
  for (int round = 0; round < rounds; ++round) {
    if (round > 0) state_.heat = again->heat;
    if (!step_heat(tried, entry)) return tried;
    if (round > 0) state_.slab = again->slab;
    if (moves && !step_mechanics(tried, temperature_n)) return tried;
  }
  return tried;
}

template <int Dim>
bool SlabRun<Dim>::grow(double level, double temperature,
                        std::optional<thermal::MetalEntry>& entry) {
  if (!mesh_.grows() || level <= mesh_.slab().level()) return false;
  mesh::SlabMesh<Dim>& slab = mesh_.slab();
  const int first_moved = slab.elements_per_row() * (slab.rows() - 1);
  slab.grow_to(level);
  {
    const Stopwatch watch(heat_seconds_);
    entry = heat_.follow_growth(state_.heat, slab.heat_nodes_per_row(), temperature);
  }
  mechanics_.follow_growth(state_.slab, slab.mesh(), slab.nodes_per_row(), first_moved);
  state_.row_heights = slab.row_heights();
  return true;
}

template <int Dim>
MergeOutcome SlabRun<Dim>::merge_rows() {
  MergeOutcome outcome;
  if (!mesh_.grows()) return outcome;
  const mesh::MergedRows merged = mesh_.slab().rows_to_merge();
  if (merged.empty()) return outcome;
  outcome.rows = static_cast<int>(merged.taken_out.size());
  const mesh::MergedRows of_heat = mesh_.slab().of_heat(merged);

  auto projected = mechanics_.projected(state_.slab, merged, element_temperature());
  mesh_.slab().merge(merged);
  {
    const Stopwatch watch(heat_seconds_);
    outcome.energy_error = heat_.follow_merging(state_.heat, of_heat);
  }
  outcome.mechanics = mechanics_.follow_merging(state_.slab, std::move(projected), mesh_.mesh(),
                                                element_temperature());

  merge_turns<Dim>(merged, state_.findings.history.when_liquid);
  merge_passages(of_heat, state_.findings.history.passages);
  state_.row_heights = mesh_.slab().row_heights();
  return outcome;
}

template <int Dim>
std::vector<double> SlabRun<Dim>::element_temperature() const {
  return mesh_.transfer().template element_means<Dim>(mesh_.heat_mesh(), state_.heat.temperature);
}

template <int Dim>
std::vector<double> SlabRun<Dim>::displacement() const {
  return mesh_.transfer().at_heat_nodes(state_.slab.displacement, Dim);
}

/// A place that has moved by u lies (u . normal) off the surface below it, to first order in u.
template <int Dim>
std::vector<double> SlabRun<Dim>::bottom_gap(std::span<const double> u) const {
  std::vector<double> gaps;
  for (std::size_t i = 0; i < block_.nodes.size(); ++i) {
    double gap = block_.initial_gap.empty() ? 0.0 : block_.initial_gap[i];
    for (std::size_t d = 0; d < Dim; ++d)
      gap += u[std::size_t(block_.nodes[i]) * Dim + d] * block_.normal[i][d];
    gaps.push_back(std::max(0.0, gap));
  }
  return gaps;
}

/// (node) vertical displacement [m], if cooling zones act on the deformed side.
template <int Dim>
std::vector<double> SlabRun<Dim>::side_rise(std::span<const double> u) const {
  std::vector<double> rise;
  if (!case_.coupling.deformed_zones || !state_.slab.started) return rise;
  for (std::size_t i = Dim - 1; i < u.size(); i += Dim) rise.push_back(u[i]);
  return rise;
}

/// (node, face) displacement of the side away from the mould [m], if a zone follows the gap. At a
/// corner each face has its own.
template <int Dim>
std::vector<double> SlabRun<Dim>::side_inward(std::span<const double> u) const {
  std::vector<double> inward;
  const auto has_gap = [](const thermal::SideZone& zone) { return zone.gap.has_value(); };
  if (!state_.slab.started || std::ranges::none_of(case_.cooling.zones, has_gap)) return inward;

  // The wide face of a solid looks along y, its narrow face and the side of a section along x.
  for (std::size_t i = 0; i < u.size(); i += Dim) {
    inward.push_back(-u[i + (Dim == 3 ? 1 : 0)]);
    inward.push_back(-u[i]);
  }
  return inward;
}

template <int Dim>
bool SlabRun<Dim>::step_heat(Attempt& tried, const std::optional<thermal::MetalEntry>& entry) {
  const std::vector<double> u = displacement();
  std::vector<double> gap;
  if (case_.coupling.gap_feedback && (state_.slab.started || !block_.initial_gap.empty()))
    gap = bottom_gap(u);

  thermal::HeatStepInput input;
  input.time = state_.time;
  input.time_step = tried.time_step;
  input.metal_level = metal_level();
  input.mould_level = mould_level();
  input.casting_temperature = schedule_.casting_temperature(state_.time, state_.cast_length);
  input.water_flow = schedule_.water_flow(state_.time, state_.cast_length);
  input.narrow_water_flow = schedule_.narrow_water_flow(state_.time, state_.cast_length);
  input.second_water_flow = schedule_.second_water_flow(state_.time, state_.cast_length);
  for (const thermal::Face face : {thermal::Face::wide, thermal::Face::narrow}) {
    input.water_temperature[std::size_t(face)] =
        schedule_.water_temperature(face, state_.time, state_.cast_length);
    input.critical_heat_flux_factor[std::size_t(face)] =
        schedule_.critical_heat_flux_factor(face, state_.time, state_.cast_length);
  }
  input.bottom_gap = gap;

  const std::vector<double> rise = side_rise(u);
  input.rise = rise;
  const std::vector<double> inward = side_inward(u);
  input.inward = inward;
  input.entry = entry;

  const Stopwatch watch(heat_seconds_);
  tried.heat = heat_.step(state_.heat, input);
  if (!tried.heat.converged) tried.diverged = Diverged::heat;
  return tried.heat.converged;
}

template <int Dim>
bool SlabRun<Dim>::step_mechanics(Attempt& tried, std::span<const double> temperature_n) {
  mechanics::SlabStepInput input;
  const std::vector<double> in_elements = element_temperature();
  const std::vector<double> at_nodes = mesh_.transfer().at_mechanics_nodes(state_.heat.temperature);
  input.element_temperature = in_elements;
  input.node_temperature = at_nodes;
  input.time_step = tried.time_step;
  input.metal_level = metal_level();
  input.mould_level = mould_level();
  input.element_temperature_n = temperature_n;

  const mechanics::StepOutcome outcome = mechanics_.step(state_.slab, input);
  const mechanics::StepOutcome before = tried.mechanics;
  tried.mechanics = outcome;
  tried.mechanics.iterations += before.iterations;
  tried.mechanics.factorizations += before.factorizations;
  tried.mechanics.solves += before.solves;
  tried.mechanics.gradient_iterations += before.gradient_iterations;
  tried.mechanics.contact_changes += before.contact_changes;

  if (!outcome.converged) tried.diverged = Diverged::mechanics;
  return outcome.converged;
}

template <int Dim>
void SlabRun<Dim>::judge(const StepFigures& step) {
  for (RunFailure& failure : casting::judge(case_, step, state_.findings)) fail(std::move(failure));
}

template class SlabRun<2>;
template class SlabRun<3>;

std::unique_ptr<CastingRun> make_run(const Case& c, int threads) {
  if (mesh::dimension_of(c.section.kind) == 2) return std::make_unique<SlabRun<2>>(c);
  return std::make_unique<SlabRun<3>>(c, threads);
}

}  // namespace dccast::casting
