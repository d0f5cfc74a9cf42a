#include <stdexcept>

#include "core/casting/run_state.hpp"

namespace dccast::casting {

namespace {

using results::Sections;
using Tensors = std::vector<SymmetricTensor<2>>;

Sections::Reals flat(const Tensors& tensors) {
  Sections::Reals values;
  values.reserve(tensors.size() * SymmetricTensor<2>::components);
  for (const auto& t : tensors) values.insert(values.end(), t.value.begin(), t.value.end());
  return values;
}

Tensors tensors(const Sections::Reals& values) {
  Tensors result(values.size() / SymmetricTensor<2>::components);
  for (std::size_t i = 0; i < values.size(); ++i) {
    result[i / SymmetricTensor<2>::components][i % SymmetricTensor<2>::components] = values[i];
  }
  return result;
}

Sections::Integers flags(const std::vector<char>& values) {
  return {values.begin(), values.end()};
}

std::vector<char> flags(const Sections::Integers& values) {
  return {values.begin(), values.end()};
}

void write_slab(const mechanics::SlabState<2>& slab, Sections& s) {
  s.set_integer("slab/started", slab.started ? 1 : 0);
  s.set("slab/displacement_m", slab.displacement);
  s.set("slab/released", flags(slab.released));
  s.set("slab/solid", flags(slab.solid));
  s.set("slab/inelastic_strain", flat(slab.inelastic));
  s.set("slab/viscoplastic_strain", flat(slab.viscoplastic));
  s.set("slab/stress_deviator_pa", flat(slab.deviator));
  s.set("slab/pressure_pa", slab.pressure);
  s.set("slab/contact", flags(slab.contact));
  s.set("slab/contact_multiplier_pa", slab.contact_multiplier);
  s.set("slab/reaction_n_per_m", slab.reaction);
}

void read_slab(const Sections& s, mechanics::SlabState<2>& slab) {
  slab.started = s.integer("slab/started") != 0;
  slab.displacement = s.reals("slab/displacement_m");
  slab.released = flags(s.integers("slab/released"));
  slab.solid = flags(s.integers("slab/solid"));
  slab.inelastic = tensors(s.reals("slab/inelastic_strain"));
  slab.viscoplastic = tensors(s.reals("slab/viscoplastic_strain"));
  slab.deviator = tensors(s.reals("slab/stress_deviator_pa"));
  slab.pressure = s.reals("slab/pressure_pa");
  slab.contact = flags(s.integers("slab/contact"));
  slab.contact_multiplier = s.reals("slab/contact_multiplier_pa");
  slab.reaction = s.reals("slab/reaction_n_per_m");
}

}  // namespace

Sections to_sections(const RunState& state, const std::string& fingerprint) {
  Sections s;
  s.set("case", fingerprint);
  s.set_integer("step", state.step);
  s.set_real("time_s", state.time);
  s.set_real("cast_length_m", state.cast_length);
  s.set_real("next_frame_s", state.next_frame);
  s.set_real("step_limit_s", state.step_limit);
  s.set_real("solver_s", state.solver_seconds);
  s.set("row_heights_m", state.row_heights);
  s.set("heat/enthalpy_j_per_m3", state.heat.enthalpy);
  s.set("heat/temperature_c", state.heat.temperature);
  s.set("heat/liquid_fraction", state.heat.liquid_fraction);
  write_slab(state.slab, s);
  return s;
}

bool from_sections(const Sections& s, const std::string& fingerprint, RunState& state) {
  try {
    if (s.text("case") != fingerprint) return false;
    state.step = s.integer("step");
    state.time = s.real("time_s");
    state.cast_length = s.real("cast_length_m");
    state.next_frame = s.real("next_frame_s");
    state.step_limit = s.real("step_limit_s");
    state.solver_seconds = s.real("solver_s");
    state.row_heights = s.reals("row_heights_m");
    state.heat.enthalpy = s.reals("heat/enthalpy_j_per_m3");
    state.heat.temperature = s.reals("heat/temperature_c");
    state.heat.liquid_fraction = s.reals("heat/liquid_fraction");
    read_slab(s, state.slab);
    return true;
  } catch (const std::out_of_range&) {
    return false;
  }
}

}  // namespace dccast::casting
