#include "core/casting/run_state.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/findings/motion.hpp"

namespace dccast::casting {

namespace {

using results::Sections;

/// Stores fields in sections, each under its name.
struct FieldWriter {
  Sections& sections;

  void operator()(const char* name, double value) const { sections.set_real(name, value); }
  void operator()(const char* name, std::int64_t value) const { sections.set_integer(name, value); }
  void operator()(const char* name, bool value) const { sections.set_integer(name, value ? 1 : 0); }
  void operator()(const char* name, const Sections::Reals& values) const {
    sections.set(name, values);
  }
  void operator()(const char* name, const std::vector<char>& flags) const {
    sections.set(name, Sections::Integers{flags.begin(), flags.end()});
  }
  template <int Dim>
  void operator()(const char* name, const std::vector<SymmetricTensor<Dim>>& tensors) const {
    Sections::Reals values;
    values.reserve(tensors.size() * SymmetricTensor<Dim>::components);
    for (const auto& t : tensors) values.insert(values.end(), t.value.begin(), t.value.end());
    sections.set(name, std::move(values));
  }
};

/// Reads them from sections. Throws std::out_of_range if a section is missing or its values are not
/// flags or not complete tensors.
struct FieldReader {
  const Sections& sections;

  void operator()(const char* name, double& value) const { value = sections.real(name); }
  void operator()(const char* name, std::int64_t& value) const { value = sections.integer(name); }
  void operator()(const char* name, bool& value) const { value = sections.integer(name) != 0; }
  void operator()(const char* name, Sections::Reals& values) const {
    values = sections.reals(name);
  }
  void operator()(const char* name, std::vector<char>& flags) const {
    const Sections::Integers& values = sections.integers(name);
    for (const std::int64_t value : values)
      if (value != 0 && value != 1)
        throw std::out_of_range("'" + std::string(name) + "' has values other than 0 and 1");
    flags.assign(values.begin(), values.end());
  }
  template <int Dim>
  void operator()(const char* name, std::vector<SymmetricTensor<Dim>>& tensors) const {
    constexpr std::size_t components = SymmetricTensor<Dim>::components;
    const Sections::Reals& values = sections.reals(name);
    if (values.size() % components != 0)
      throw std::out_of_range("'" + std::string(name) + "' has incomplete tensors");
    tensors.resize(values.size() / components);
    for (std::size_t i = 0; i < values.size(); ++i)
      tensors[i / components][i % components] = values[i];
  }
};

/// Calls use(name, field) for every field of a slab, constant or not.
template <class Slab, class Use>
void for_slab_fields(Slab& slab, const Use& use) {
  use("slab/started", slab.started);
  use("slab/displacement_m", slab.displacement);
  use("slab/released", slab.released);
  use("slab/solid", slab.solid);
  use("slab/inelastic_strain", slab.inelastic);
  use("slab/viscoplastic_strain", slab.viscoplastic);
  use("slab/hardened_strain", slab.hardened);
  use("slab/stress_deviator_pa", slab.deviator);
  use("slab/pressure_pa", slab.pressure);
  use("slab/contact", slab.contact);
  use("slab/contact_multiplier_pa", slab.contact_multiplier);
  use("slab/reaction_n_per_m", slab.reaction);
}

/// The same for a run, without findings and failures.
template <class State, class Use>
void for_fields(State& state, const Use& use) {
  use("step", state.step);
  use("time_s", state.time);
  use("cast_length_m", state.cast_length);
  use("next_frame_s", state.next_frame);
  use("step_limit_s", state.step_limit);
  use("solver_s", state.solver_seconds);
  use("process_s", state.process_seconds);
  use("superheat_j_per_m", state.superheat);
  use("level_heat_j_per_m", state.level_heat);
  use("row_heights_m", state.row_heights);

  use("heat/enthalpy_j_per_m3", state.heat.enthalpy);
  use("heat/temperature_c", state.heat.temperature);
  use("heat/liquid_fraction", state.heat.liquid_fraction);
  use("heat/enthalpy_rate_w_per_m3", state.heat.enthalpy_rate);
  use("heat/wetted", state.heat.wetted);
  use("heat/block_temperature_c", state.heat.block_temperature);
  use("heat/gap_wetted", state.heat.gap_wetted);
  for_slab_fields(state.slab, use);
}

void write_failures(const RunFailures& failures, Sections& s) {
  s.set_integer("failures", static_cast<std::int64_t>(failures.size()));
  for (std::size_t i = 0; i < failures.size(); ++i) {
    const RunFailure& failure = failures[i];
    const std::string prefix = "failure." + std::to_string(i) + '/';
    s.set(prefix + "kind", name_of(failure.kind));
    s.set(prefix + "message", failure.message);
    s.set(prefix + "time_and_step_s", Sections::Reals{failure.time, failure.time_step});
    s.set(prefix + "place_m", failure.place);
    s.set(prefix + "residual_history", failure.residual_history);
    s.set(prefix + "finding", failure.finding);
  }
}

/// @throws std::out_of_range  a section is missing, or names an unknown kind
RunFailure read_failure(const Sections& s, const std::string& prefix) {
  const auto kind = failure_kind(s.text(prefix + "kind"));
  if (!kind) throw std::out_of_range("unknown kind of failure");
  const auto& times = s.reals(prefix + "time_and_step_s");
  return {*kind,
          s.text(prefix + "message"),
          times.at(0),
          times.at(1),
          s.reals(prefix + "place_m"),
          s.reals(prefix + "residual_history"),
          s.text(prefix + "finding")};
}

RunFailures read_failures(const Sections& s) {
  RunFailures failures;
  const std::int64_t count = s.integer("failures");
  for (std::int64_t i = 0; i < count; ++i)
    failures.push_back(read_failure(s, "failure." + std::to_string(i) + '/'));
  return failures;
}

}  // namespace

template <int Dim>
Sections to_sections(const RunState<Dim>& state) {
  Sections s;
  for_fields(state, FieldWriter{s});
  write_findings(state.findings, s);
  write_failures(state.failures, s);
  return s;
}

template <int Dim>
RunState<Dim> state_of(const Sections& s) {
  RunState<Dim> state;
  for_fields(state, FieldReader{s});
  state.findings = read_findings(s);
  state.failures = read_failures(s);
  return state;
}

template Sections to_sections(const RunState<2>&);
template Sections to_sections(const RunState<3>&);
template RunState<2> state_of<2>(const Sections&);
template RunState<3> state_of<3>(const Sections&);

namespace {

constexpr double same_height = 1e-9;  // [m]

/// Collects the first reason against a state.
class Reasons {
public:
  void require(bool good, const std::string& otherwise) {
    if (!good && first_.empty()) first_ = otherwise;
  }
  template <class Array>
  void require_size(const Array& array, std::size_t size, const std::string& name) {
    require(array.size() == size, name + " has " + std::to_string(array.size()) + " values for " +
                                      std::to_string(size) + " on the mesh");
  }
  void require_finite(const std::vector<double>& array, const std::string& name) {
    require(std::ranges::all_of(array, [](double v) { return std::isfinite(v); }),
            name + " has values that are not finite");
  }
  void require_reals(const std::vector<double>& array, std::size_t size, const std::string& name) {
    require_size(array, size, name);
    require_finite(array, name);
  }
  template <int Dim>
  void require_tensors(const std::vector<SymmetricTensor<Dim>>& array, std::size_t size,
                       const std::string& name) {
    require_size(array, size, name);
    for (const auto& tensor : array)
      require(std::ranges::all_of(tensor.value, [](double v) { return std::isfinite(v); }),
              name + " has values that are not finite");
  }
  const std::string& first() const { return first_; }

private:
  std::string first_;
};

/// Sizes of the arrays of a state required by a mesh.
struct Shape {
  std::size_t nodes, elements, points, bottom_nodes;
};

/// The same by the mesh of the heat and by that of the mechanics.
struct Shapes {
  Shape heat, mechanics;
};

void fit_heat(const thermal::HeatField& heat, const Shape& shape, Reasons& reasons) {
  reasons.require_reals(heat.enthalpy, shape.nodes, "enthalpy");
  reasons.require_reals(heat.temperature, shape.nodes, "temperature");
  reasons.require_reals(heat.liquid_fraction, shape.nodes, "liquid fraction");
  // Empty before the first step, and where the temperature is prescribed.
  if (!heat.enthalpy_rate.empty())
    reasons.require_reals(heat.enthalpy_rate, shape.nodes, "enthalpy rate");
  // Empty before the first step, and without `boiling_follows_flow`.
  if (!heat.wetted.empty())
    reasons.require_reals(heat.wetted, thermal::faces * shape.nodes, "wetted share");
  // Empty before the first step, and where the block keeps its temperature.
  if (!heat.block_temperature.empty())
    reasons.require_reals(heat.block_temperature,
                          thermal::BlockColumns::points * shape.bottom_nodes, "block temperature");
  // Empty before the first step, and without water that runs into the gap.
  if (!heat.gap_wetted.empty())
    reasons.require_reals(heat.gap_wetted, shape.bottom_nodes, "wetted share of the bottom");
}

template <int Dim>
void fit_slab(const mechanics::SlabState<Dim>& slab, const Shape& shape, Reasons& reasons) {
  reasons.require_reals(slab.displacement, Dim * shape.nodes, "displacement");
  reasons.require_size(slab.released, shape.nodes, "released nodes");
  reasons.require_size(slab.solid, shape.elements, "solid elements");
  reasons.require_tensors(slab.inelastic, shape.points, "inelastic strain");
  reasons.require_tensors(slab.viscoplastic, shape.points, "viscoplastic strain");
  if (!slab.hardened.empty()) reasons.require_reals(slab.hardened, shape.points, "hardened strain");
  reasons.require_tensors(slab.deviator, shape.points, "stress deviator");
  reasons.require_reals(slab.pressure, shape.points, "pressure");
  reasons.require_size(slab.contact, shape.bottom_nodes, "contact");
  reasons.require_reals(slab.reaction, shape.bottom_nodes, "reaction");
  // Empty before the first step, and with any algorithm except sbm.
  if (!slab.contact_multiplier.empty())
    reasons.require_reals(slab.contact_multiplier, shape.bottom_nodes, "contact multiplier");
}

template <int Dim>
void fit_course(const RunState<Dim>& state, const RunShape<Dim>& run, Reasons& reasons) {
  const CastingSchedule& schedule = run.schedule;
  reasons.require(state.step >= 0, "its step is negative");
  reasons.require(state.time >= schedule.begin() && state.time <= schedule.end() + 1e-9,
                  "its time is outside the run");
  reasons.require(state.next_frame >= schedule.begin() && std::isfinite(state.next_frame),
                  "the time of its next frame is outside the run");
  reasons.require(state.step_limit >= run.casting_case.time.minimum_step,
                  "its time step is too small");
  reasons.require(std::isfinite(state.cast_length), "its cast length is not finite");
}

template <int Dim>
void fit_rows(const RunState<Dim>& state, const RunShape<Dim>& run, Reasons& reasons) {
  const auto& heights = state.row_heights;
  const mesh::SlabMesh<Dim>* slab = run.mesh.in_rows();
  if (slab == nullptr) {
    reasons.require(heights.empty(), "it has rows, but the mesh has none");
    return;
  }
  reasons.require_finite(heights, "row heights");
  reasons.require(heights.size() > std::size_t(slab->rows()), "it has too few rows");
  reasons.require(std::ranges::is_sorted(heights, std::less_equal{}), "its rows do not ascend");
  if (!reasons.first().empty()) return;
  const double level = run.mesh.level_at(run.schedule, state.time, state.cast_length);
  reasons.require(std::abs(heights.back() - level) <= same_height,
                  "its rows do not end at its metal level");
}

/// Checks against the mesh given by the rows of a state.
template <int Dim>
Shapes shapes_of(const RunState<Dim>& state, const RunShape<Dim>& run) {
  const auto of_mesh = [](const mesh::Mesh<Dim>& mesh) {
    return Shape{std::size_t(mesh.nodes()), std::size_t(mesh.elements()), 0,
                 mesh::patch_nodes(mesh, mesh::PatchKind::bottom).size()};
  };
  Shapes shapes{of_mesh(run.mesh.heat_mesh()), of_mesh(run.mesh.mesh())};

  if (const mesh::SlabMesh<Dim>* slab = run.mesh.in_rows()) {
    const std::size_t rows = state.row_heights.size();
    shapes.heat.nodes = rows * std::size_t(slab->heat_nodes_per_row());
    shapes.heat.elements = (rows - 1) * std::size_t(slab->heat_elements_per_row());
    shapes.mechanics.nodes = rows * std::size_t(slab->nodes_per_row());
    shapes.mechanics.elements = (rows - 1) * std::size_t(slab->elements_per_row());
  }
  for (Shape* shape : {&shapes.heat, &shapes.mechanics})
    shape->points = shape->elements * run.points;
  return shapes;
}

}  // namespace

template <int Dim>
std::string misfit(const RunState<Dim>& state, const RunShape<Dim>& run) {
  Reasons reasons;
  fit_course(state, run, reasons);

  fit_rows(state, run, reasons);
  if (!reasons.first().empty()) return reasons.first();
  const auto [heat, mechanics] = shapes_of(state, run);
  fit_heat(state.heat, heat, reasons);
  fit_slab(state.slab, mechanics, reasons);

  const std::vector<double>& when_liquid = state.findings.history.when_liquid;
  if (!when_liquid.empty())  // before the mechanics begins nothing turns
    reasons.require_reals(when_liquid, mechanics.elements * std::tuple_size_v<Turn<Dim>>,
                          "rotation when liquid");
  // Without a window of hot tears nothing is followed.
  if (!state.findings.history.passages.empty())
    reasons.require_size(state.findings.history.passages, heat.elements, "passage of the mush");

  for (const Finding& finding : state.findings.raised) {
    if (!finding.place.empty()) reasons.require_reals(finding.place, Dim, "the place of a finding");
    if (finding.worst && !finding.worst->place.empty())
      reasons.require_reals(finding.worst->place, Dim, "the place of a finding");
  }
  return reasons.first();
}

template std::string misfit(const RunState<2>&, const RunShape<2>&);
template std::string misfit(const RunState<3>&, const RunShape<3>&);

}  // namespace dccast::casting
