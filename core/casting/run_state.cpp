#include "core/casting/run_state.hpp"

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

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
  use("slab/solid", slab.solid);
  use("slab/carries", slab.carries);
  use("slab/inelastic_strain", slab.inelastic);
  use("slab/viscoplastic_strain", slab.viscoplastic);
  use("slab/hardened_strain", slab.hardened);
  use("slab/stress_deviator_pa", slab.deviator);
  use("slab/pressure_pa", slab.pressure);
  use("slab/contact", slab.contact);
  use("slab/leaning", slab.leaning);
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
  use("curl/time_s", state.curl.time);
  use("curl/curl_m", state.curl.curl);
  use("settled_at_s", state.settled_at);

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

}  // namespace dccast::casting
