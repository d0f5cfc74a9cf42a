#include "core/findings/validity_state.hpp"

#include <string>

namespace dccast::casting {

using restart::Sections;

void write_validity(const ValidityState& state, Sections& s) {
  s.set_integer("validity/shell_stood", state.shell_stood ? 1 : 0);
  s.set("validity/when_liquid", state.when_liquid);
  s.set_integer("validity/lost", state.lost ? 1 : 0);
  if (!state.lost) return;
  const ValidityLoss& loss = *state.lost;
  s.set("validity/kind", loss.kind);
  s.set("validity/message", loss.message);
  s.set("validity/unit", loss.unit);
  s.set("validity/place_m", loss.place);
  s.set("validity/time_value_limit", Sections::Reals{loss.time, loss.value, loss.limit});
}

ValidityState read_validity(const Sections& s) {
  ValidityState state;
  state.shell_stood = s.integer("validity/shell_stood") != 0;
  state.when_liquid = s.reals("validity/when_liquid");
  if (s.integer("validity/lost") == 0) return state;
  const auto& numbers = s.reals("validity/time_value_limit");
  state.lost = ValidityLoss{s.text("validity/kind"), s.text("validity/message"),
                            numbers.at(0),           s.reals("validity/place_m"),
                            numbers.at(1),           numbers.at(2),
                            s.text("validity/unit")};
  return state;
}

}  // namespace dccast::casting
