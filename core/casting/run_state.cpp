#include "core/casting/run_state.hpp"

#include <stdexcept>
#include <string>

namespace dccast::casting {

namespace {

using restart::Sections;
template <int Dim>
using Tensors = std::vector<SymmetricTensor<Dim>>;

template <int Dim>
Sections::Reals flat(const Tensors<Dim>& tensors) {
  Sections::Reals values;
  values.reserve(tensors.size() * SymmetricTensor<Dim>::components);
  for (const auto& t : tensors) values.insert(values.end(), t.value.begin(), t.value.end());
  return values;
}

/// @throws std::out_of_range  the values are not whole tensors
template <int Dim>
Tensors<Dim> tensors(const Sections& s, const std::string& name) {
  constexpr std::size_t components = SymmetricTensor<Dim>::components;
  const Sections::Reals& values = s.reals(name);
  if (values.size() % components != 0)
    throw std::out_of_range("'" + name + "' is no whole tensors");
  Tensors<Dim> result(values.size() / components);
  for (std::size_t i = 0; i < values.size(); ++i)
    result[i / components][i % components] = values[i];
  return result;
}

Sections::Integers flags(const std::vector<char>& values) {
  return {values.begin(), values.end()};
}

/// @throws std::out_of_range  a value is neither 0 nor 1
std::vector<char> flags(const Sections& s, const std::string& name) {
  const Sections::Integers& values = s.integers(name);
  for (const std::int64_t value : values)
    if (value != 0 && value != 1) throw std::out_of_range("'" + name + "' has more than 0 and 1");
  return {values.begin(), values.end()};
}

template <int Dim>
void write_slab(const mechanics::SlabState<Dim>& slab, Sections& s) {
  s.set_integer("slab/started", slab.started ? 1 : 0);
  s.set("slab/displacement_m", slab.displacement);
  s.set("slab/released", flags(slab.released));
  s.set("slab/solid", flags(slab.solid));
  s.set("slab/inelastic_strain", flat<Dim>(slab.inelastic));
  s.set("slab/viscoplastic_strain", flat<Dim>(slab.viscoplastic));
  s.set("slab/stress_deviator_pa", flat<Dim>(slab.deviator));
  s.set("slab/pressure_pa", slab.pressure);
  s.set("slab/contact", flags(slab.contact));
  s.set("slab/contact_multiplier_pa", slab.contact_multiplier);
  s.set("slab/reaction_n_per_m", slab.reaction);
}

template <int Dim>
void read_slab(const Sections& s, mechanics::SlabState<Dim>& slab) {
  slab.started = s.integer("slab/started") != 0;
  slab.displacement = s.reals("slab/displacement_m");
  slab.released = flags(s, "slab/released");
  slab.solid = flags(s, "slab/solid");
  slab.inelastic = tensors<Dim>(s, "slab/inelastic_strain");
  slab.viscoplastic = tensors<Dim>(s, "slab/viscoplastic_strain");
  slab.deviator = tensors<Dim>(s, "slab/stress_deviator_pa");
  slab.pressure = s.reals("slab/pressure_pa");
  slab.contact = flags(s, "slab/contact");
  slab.contact_multiplier = s.reals("slab/contact_multiplier_pa");
  slab.reaction = s.reals("slab/reaction_n_per_m");
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
  }
}

/// @throws std::out_of_range  a section is missing, or names an unknown kind
RunFailure read_failure(const Sections& s, const std::string& prefix) {
  const auto kind = failure_kind(s.text(prefix + "kind"));
  if (!kind) throw std::out_of_range("unknown kind of failure");
  const auto& times = s.reals(prefix + "time_and_step_s");
  return {*kind,       s.text(prefix + "message"),  times.at(0),
          times.at(1), s.reals(prefix + "place_m"), s.reals(prefix + "residual_history")};
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
  s.set_integer("step", state.step);
  s.set_real("time_s", state.time);
  s.set_real("cast_length_m", state.cast_length);
  s.set_real("next_frame_s", state.next_frame);
  s.set_real("step_limit_s", state.step_limit);
  s.set_real("solver_s", state.solver_seconds);
  s.set_real("process_s", state.process_seconds);
  s.set("row_heights_m", state.row_heights);
  s.set("heat/enthalpy_j_per_m3", state.heat.enthalpy);
  s.set("heat/temperature_c", state.heat.temperature);
  s.set("heat/liquid_fraction", state.heat.liquid_fraction);
  s.set("heat/wetted", flags(state.heat.wetted));
  write_slab(state.slab, s);
  write_validity(state.validity, s);
  write_plausibility(state.plausibility, s);
  write_failures(state.failures, s);
  return s;
}

template <int Dim>
RunState<Dim> state_of(const Sections& s) {
  RunState<Dim> state;
  state.step = s.integer("step");
  state.time = s.real("time_s");
  state.cast_length = s.real("cast_length_m");
  state.next_frame = s.real("next_frame_s");
  state.step_limit = s.real("step_limit_s");
  state.solver_seconds = s.real("solver_s");
  state.process_seconds = s.real("process_s");
  state.row_heights = s.reals("row_heights_m");
  state.heat.enthalpy = s.reals("heat/enthalpy_j_per_m3");
  state.heat.temperature = s.reals("heat/temperature_c");
  state.heat.liquid_fraction = s.reals("heat/liquid_fraction");
  state.heat.wetted = flags(s, "heat/wetted");
  read_slab(s, state.slab);
  state.validity = read_validity(s);
  state.plausibility = read_plausibility(s);
  state.failures = read_failures(s);
  return state;
}

template Sections to_sections(const RunState<2>&);
template Sections to_sections(const RunState<3>&);
template RunState<2> state_of<2>(const Sections&);
template RunState<3> state_of<3>(const Sections&);

}  // namespace dccast::casting
