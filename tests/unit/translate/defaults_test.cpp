// Defaults stand in case.proto. The structs of core have values of their own, for cases that tests
// and the verification program build in code; they must be the same.
#include <gtest/gtest.h>

#include <iomanip>
#include <sstream>

#include "proto/case_file/case_file.hpp"
#include "server/translate/case_to_core.hpp"

namespace dccast::translate {
namespace {

class Line {
public:
  Line() { text_ << std::setprecision(12); }  // a unit's factor may cost the last bit
  template <class... Values>
  Line& add(const Values&... values) {
    ((text_ << values << ' '), ...);
    return *this;
  }
  std::string text() const { return text_.str(); }

private:
  std::ostringstream text_;
};

void add(const mechanics::Options& o, Line& line) {
  line.add("mechanics", int(o.algorithm), o.gravity, int(o.liquid), o.liquid_modulus,
           o.liquid_epsilon, o.liquid_delta, o.liquid_beta, o.confinement, int(o.confinement_by),
           o.confinement_stiffness, o.mould_wall, o.contact, o.tolerance,
           o.maximum_iterations.value_or(-1));
  const mechanics::AlgorithmParameters& p = o.parameters;
  line.add("parameters", p.gamma_p, p.lambda_p.value_or(-1.0), p.gamma_c, p.lambda_c.value_or(-1.0),
           p.relaxation, p.plain, p.increment_test);
}

void add(const thermal::CoolingSpec& c, Line& line) {
  line.add("cooling", c.dry_coefficient, c.ambient_temperature, int(c.top));
  const thermal::Water& w = c.water;
  line.add("water", w.enabled, w.from, w.start, w.critical_heat_flux, w.film_boiling,
           w.film_boiling_coefficient, w.film_boiling_above, w.pulse_period, w.pulse_share,
           w.pulse_end);  // boiling_follows_flow has no default in core: its constants have none
}

/// Every number, flag and choice of a case that has a default, but for those that its quality
/// picks.
std::string values_of(const casting::Case& c) {
  Line line;
  const mesh::SectionSpec& s = c.section;
  line.add("section", int(s.kind), int(s.element), s.refinement, s.growth);
  line.add("schedule", c.schedule.hold, c.schedule.casting_speed_shift,
           c.schedule.water_flow_shift);
  add(c.cooling, line);
  line.add("thermal", c.thermal.tolerance, c.thermal.maximum_iterations);
  line.add("start", c.mechanics.enabled, c.mechanics.start);
  add(c.mechanics.options, line);
  line.add("coupling", c.coupling.gap_feedback, c.coupling.iterations, c.coupling.deformed_zones);
  line.add("time", c.time.minimum_step);
  line.add("output", c.output.frame_interval, c.output.stresses);
  line.add("checkpoint", c.checkpoint.every_steps, c.checkpoint.every_seconds);
  const casting::Validity& v = c.validity;
  line.add("validity", int(v.when_lost), v.maximum_liquid_pressure_error, v.maximum_rotation,
           v.maximum_slip, v.minimum_shell);
  const casting::Plausibility& p = c.plausibility;
  line.add("plausibility", p.minimum_superheat, p.minimum_shell, p.maximum_mush_strain,
           p.maximum_sump_share);
  line.add("limits", c.limits.maximum_nodes, c.limits.maximum_steps);
  return line.text();
}

TEST(DefaultsOfACase, AreThoseOfTheCore) {
  v1::Case complete;
  case_file::apply_defaults(complete);
  EXPECT_EQ(values_of(to_core(complete, "")), values_of(to_core(v1::Case{}, "")));
}

}  // namespace
}  // namespace dccast::translate
