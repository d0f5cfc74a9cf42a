#include "core/findings/plausibility_state.hpp"

#include <stdexcept>
#include <string>

namespace dccast::casting {

namespace {

using restart::Sections;

/// Of what may be absent: nothing or one value.
Sections::Reals as_reals(const std::optional<double>& value) {
  return value ? Sections::Reals{*value} : Sections::Reals{};
}

/// @throws std::out_of_range  more than one value
std::optional<double> as_optional(const Sections& s, const std::string& name) {
  const Sections::Reals& values = s.reals(name);
  if (values.size() > 1) throw std::out_of_range("'" + name + "' is more than one number");
  return values.empty() ? std::nullopt : std::optional(values.front());
}

void write_finding(const Finding& finding, const std::string& prefix, Sections& s) {
  s.set(prefix + "code", finding.code);
  s.set_integer(prefix + "severity", static_cast<std::int64_t>(finding.severity));
  s.set(prefix + "message", finding.message);
  s.set(prefix + "time_s", as_reals(finding.time));
  s.set(prefix + "place_m", finding.place);
  s.set(prefix + "value", as_reals(finding.value));
  s.set(prefix + "limit", as_reals(finding.limit));
  s.set(prefix + "unit", finding.unit);
  s.set(prefix + "key", finding.key);
}

Severity severity_of(std::int64_t number) {
  if (number < 0 || number > 2) throw std::out_of_range("unknown severity of a finding");
  return static_cast<Severity>(number);
}

Finding read_finding(const Sections& s, const std::string& prefix) {
  return {s.text(prefix + "code"),
          severity_of(s.integer(prefix + "severity")),
          s.text(prefix + "message"),
          as_optional(s, prefix + "time_s"),
          s.reals(prefix + "place_m"),
          as_optional(s, prefix + "value"),
          as_optional(s, prefix + "limit"),
          s.text(prefix + "unit"),
          s.text(prefix + "key")};
}

std::string prefix_of(std::size_t number) {
  return "finding." + std::to_string(number) + '/';
}

}  // namespace

void write_plausibility(const PlausibilityState& state, Sections& s) {
  s.set_real("plausibility/thickest_bottom_shell_m", state.thickest_bottom_shell);
  s.set_integer("findings", static_cast<std::int64_t>(state.raised.size()));
  for (std::size_t i = 0; i < state.raised.size(); ++i)
    write_finding(state.raised[i], prefix_of(i), s);
}

PlausibilityState read_plausibility(const Sections& s) {
  PlausibilityState state;
  state.thickest_bottom_shell = s.real("plausibility/thickest_bottom_shell_m");
  const auto count = static_cast<std::size_t>(s.integer("findings"));
  for (std::size_t i = 0; i < count; ++i) state.raised.push_back(read_finding(s, prefix_of(i)));
  return state;
}

}  // namespace dccast::casting
