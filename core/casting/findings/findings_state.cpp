#include <fmt/format.h>

#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/casting/findings/judge.hpp"

// The state of the judge in a checkpoint.
namespace dccast::casting {

namespace {

using results::Exceedance;
using results::Sections;

/// A value that may be absent, as an array of no or one number.
Sections::Reals as_reals(const std::optional<double>& value) {
  return value ? Sections::Reals{*value} : Sections::Reals{};
}

/// Reads a value that may be absent. @throws std::out_of_range  there are several numbers
std::optional<double> read_optional(const Sections& s, const std::string& name) {
  const Sections::Reals& values = s.reals(name);
  if (values.size() > 1) throw std::out_of_range(fmt::format("'{}' is more than one number", name));
  return values.empty() ? std::nullopt : std::optional(values.front());
}

/// Time, value and coordinates in one array.
Sections::Reals as_reals(const std::optional<Exceedance>& worst) {
  if (!worst) return {};
  Sections::Reals values{worst->time, worst->value};
  values.insert(values.end(), worst->place.begin(), worst->place.end());
  return values;
}

/// Reads the worst exceedance. Exactly the findings with a time and a value have one.
/// @throws std::out_of_range  it is missing, incomplete, or should not be there
std::optional<Exceedance> read_worst(const Finding& finding, const Sections::Reals& values) {
  const bool has_worst = finding.time && finding.value;
  if (values.empty() == has_worst || values.size() == 1)
    throw std::out_of_range("wrong number of values for the worst exceedance of a finding");
  if (values.empty()) return std::nullopt;
  return Exceedance{values[0], values[1], {values.begin() + 2, values.end()}};
}

constexpr std::int64_t unknown = -1;  // certainty

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
  s.set(prefix + "worst", as_reals(finding.worst));
  s.set_integer(prefix + "certainty",
                finding.certainty ? static_cast<std::int64_t>(*finding.certainty) : unknown);
  s.set(prefix + "lower_error", as_reals(finding.lower_error));
  s.set(prefix + "upper_error", as_reals(finding.upper_error));
}

Finding read_finding(const Sections& s, const std::string& prefix) {
  const std::int64_t severity = s.integer(prefix + "severity");
  if (severity < 0 || severity > 2) throw std::out_of_range("unknown severity of a finding");

  Finding finding{s.text(prefix + "code"),
                  static_cast<Severity>(severity),
                  s.text(prefix + "message"),
                  read_optional(s, prefix + "time_s"),
                  s.reals(prefix + "place_m"),
                  read_optional(s, prefix + "value"),
                  read_optional(s, prefix + "limit"),
                  s.text(prefix + "unit"),
                  s.text(prefix + "key")};

  finding.worst = read_worst(finding, s.reals(prefix + "worst"));
  const std::int64_t certainty = s.integer(prefix + "certainty");
  if (certainty < unknown || certainty > 2)
    throw std::out_of_range("unknown certainty of a finding");
  if (certainty != unknown) finding.certainty = static_cast<results::Certainty>(certainty);
  finding.lower_error = read_optional(s, prefix + "lower_error");
  finding.upper_error = read_optional(s, prefix + "upper_error");
  return finding;
}

/// Value and limit with time and coordinates of the value.
void write_margin(const Margin& margin, const std::string& prefix, Sections& s) {
  s.set(prefix + "code", margin.code);
  s.set(prefix + "key", margin.key);
  s.set(prefix + "unit", margin.unit);
  s.set_real(prefix + "limit", margin.limit);
  s.set(prefix + "worst", as_reals(margin.worst));
}

Margin read_margin(const Sections& s, const std::string& prefix) {
  const Sections::Reals& worst = s.reals(prefix + "worst");
  if (worst.size() < 2) throw std::out_of_range("a margin has no time or no value");
  return {s.text(prefix + "code"), s.text(prefix + "key"), s.text(prefix + "unit"),
          s.real(prefix + "limit"),
          Exceedance{worst[0], worst[1], {worst.begin() + 2, worst.end()}}};
}

std::string margin_prefix(std::size_t number) {
  return fmt::format("margin.{}/", number);
}

std::string finding_prefix(std::size_t number) {
  return fmt::format("finding.{}/", number);
}

constexpr std::size_t numbers_of_passage = 6;

/// (element, 6): temperature, strain, time and the integrals of the feeding.
Sections::Reals as_reals(const std::vector<MushPassage>& passages) {
  Sections::Reals values;
  values.reserve(passages.size() * numbers_of_passage);
  for (const MushPassage& p : passages)
    values.insert(values.end(), {p.temperature, p.strain, p.time, p.feeding.resistance,
                                 p.feeding.stretched, p.feeding.shrunk});
  return values;
}

/// @throws std::out_of_range  the last passage is incomplete
std::vector<MushPassage> read_passages(const Sections::Reals& values) {
  if (values.size() % numbers_of_passage != 0)
    throw std::out_of_range("the passages through the mush are incomplete");
  std::vector<MushPassage> passages;
  for (std::size_t i = 0; i < values.size(); i += numbers_of_passage)
    passages.push_back(
        {.temperature = values[i],
         .strain = values[i + 1],
         .time = values[i + 2],
         .feeding = {
             .resistance = values[i + 3], .stretched = values[i + 4], .shrunk = values[i + 5]}});
  return passages;
}

Sections::Reals as_reals(const TearIndices& tears) {
  const TearIndex &rate = tears.strain_rate, &pressure = tears.pressure;
  return {rate.overall,     rate.centre,     rate.surface,
          pressure.overall, pressure.centre, pressure.surface};
}

/// @throws std::out_of_range  there are too few or too many
TearIndices read_tears(const Sections::Reals& values) {
  constexpr std::size_t numbers_of_tears = 6;
  if (values.size() != numbers_of_tears)
    throw std::out_of_range("there are not as many indices of hot tears as there should be");
  return {{values.at(0), values.at(1), values.at(2)}, {values.at(3), values.at(4), values.at(5)}};
}

void write_loss(const std::optional<ValidityLoss>& lost, Sections& s) {
  s.set_integer("validity/lost", lost ? 1 : 0);
  if (!lost) return;
  s.set("validity/kind", lost->kind);
  s.set("validity/message", lost->message);
  s.set("validity/unit", lost->unit);
  s.set("validity/place_m", lost->place);
  s.set("validity/time_value_limit", Sections::Reals{lost->time, lost->value, lost->limit});
}

std::optional<ValidityLoss> read_loss(const Sections& s) {
  if (s.integer("validity/lost") == 0) return std::nullopt;
  const auto& numbers = s.reals("validity/time_value_limit");
  return ValidityLoss{s.text("validity/kind"), s.text("validity/message"),
                      numbers.at(0),           s.reals("validity/place_m"),
                      numbers.at(1),           numbers.at(2),
                      s.text("validity/unit")};
}

}  // namespace

void write_findings(const FindingsState& state, Sections& s) {
  s.set_integer("figures/shell_stood", state.history.shell_stood ? 1 : 0);
  s.set("figures/when_liquid", state.history.when_liquid);
  s.set_real("figures/thickest_bottom_shell_m", state.history.thickest_bottom_shell);
  s.set_real("figures/wall_force", state.history.wall_force);
  s.set("figures/passages", as_reals(state.history.passages));
  s.set("figures/tears", as_reals(state.history.tears));
  s.set_real("figures/pore_volume", state.history.pore_volume);
  write_loss(state.lost, s);

  s.set_integer("findings", static_cast<std::int64_t>(state.raised.size()));
  for (std::size_t i = 0; i < state.raised.size(); ++i)
    write_finding(state.raised[i], finding_prefix(i), s);
  s.set_integer("margins", static_cast<std::int64_t>(state.margins.size()));
  for (std::size_t i = 0; i < state.margins.size(); ++i)
    write_margin(state.margins[i], margin_prefix(i), s);
}

FindingsState read_findings(const Sections& s) {
  FindingsState state;
  state.history.shell_stood = s.integer("figures/shell_stood") != 0;
  state.history.when_liquid = s.reals("figures/when_liquid");
  state.history.thickest_bottom_shell = s.real("figures/thickest_bottom_shell_m");
  state.history.wall_force = s.real("figures/wall_force");
  state.history.passages = read_passages(s.reals("figures/passages"));
  state.history.tears = read_tears(s.reals("figures/tears"));
  state.history.pore_volume = s.real("figures/pore_volume");
  state.lost = read_loss(s);

  const auto count = static_cast<std::size_t>(s.integer("findings"));
  for (std::size_t i = 0; i < count; ++i)
    state.raised.push_back(read_finding(s, finding_prefix(i)));
  const auto margins = static_cast<std::size_t>(s.integer("margins"));
  for (std::size_t i = 0; i < margins; ++i)
    state.margins.push_back(read_margin(s, margin_prefix(i)));
  return state;
}

}  // namespace dccast::casting
