#include "proto/case_file/uncertainty.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <set>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/override.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/case_file/schema.hpp"

namespace dccast::case_file {
namespace {

/// A number with its unit as written, e.g. 10 and "%".
struct Written {
  double number = 0.0;
  std::string unit;
};

std::optional<Written> parse_number(std::string_view text) {
  Written result;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), result.number);
  if (error != std::errc{} || !std::isfinite(result.number)) return std::nullopt;
  result.unit = trimmed(text.substr(rest - text.data()));
  return result;
}

std::string format_number(double number, const std::string& unit) {
  return unit.empty() ? number_text(number) : fmt::format("{} {}", number_text(number), unit);
}

/// The range "± text".
std::optional<Range> parse_symmetric(std::string_view text) {
  const auto half = parse_number(text);
  if (!half || !(half->number > 0.0)) return std::nullopt;
  if (half->unit != "%")
    return Range{".offset", format_number(-half->number, half->unit),
                 format_number(half->number, half->unit)};

  const double share = half->number / 100.0;
  if (share >= 1.0) return std::nullopt;
  return Range{".scale", number_text(1.0 - share), number_text(1.0 + share)};
}

/// The range "first..second".
std::optional<Range> parse_interval(std::string_view first, std::string_view second) {
  auto low = parse_number(first);
  const auto high = parse_number(second);
  if (!low || !high) return std::nullopt;
  if (low->unit.empty()) low->unit = high->unit;
  if (low->unit == high->unit && !(low->number < high->number)) return std::nullopt;
  if (high->unit != "times")
    return Range{"", format_number(low->number, low->unit),
                 format_number(high->number, high->unit)};
  if (low->unit != "times" || !(low->number > 0.0)) return std::nullopt;
  return Range{".scale", number_text(low->number), number_text(high->number)};
}

/// Whether a default affects a run of this case.
bool is_used(const v1::Case& c, const std::string& key) {
  const auto& cooling = c.cooling();
  if (key == "cooling.level_coefficient") return cooling.top() == v1::Cooling::POURING;
  if (key.starts_with("cooling.narrow_water.")) return false;  // varied with those of the wide face
  if (key.starts_with("cooling.water.wetting."))
    return cooling.water().enabled() && cooling.water().boiling_follows_flow();
  if (key.starts_with("cooling.water.")) return cooling.water().enabled();
  if (key == "cooling.bottom_block.cooling_coefficient")
    return cooling.bottom_block().has_thickness_m();
  if (key == "cooling.bottom_block.wet_gap")
    return cooling.bottom_block().has_wet_coefficient_w_per_m2_k() ||
           cooling.bottom_block().has_gap_water();
  if (key.starts_with("cooling.bottom_block.gap_water."))
    return cooling.bottom_block().has_gap_water();
  return true;
}

/// Whether a key has its default value.
bool is_default(const v1::Case& complete, const KeyReference& row) {
  std::string text = row.default_text;
  std::erase(text, '"');
  const Quantity value = parse_quantity(text, row.unit);
  const auto here = number_at(complete, row.path);
  return value.value && here && *here == *value.value;
}

/// The fault of a range that a complete case gives; empty if there is none.
std::optional<v1::Fault> find_fault(const v1::Case& complete, const std::string& key,
                                    const std::string& range) {
  const auto refused = [&](const std::string& message, const std::string& permitted = {},
                           const std::string& remedy = {}) {
    return make_fault(fmt::format("uncertainty.{}", key), range, message, permitted, remedy);
  };

  const auto ends = parse_range(range);
  if (!ends) return refused("is no range", range_forms);

  // Both ends must be permitted values of the key.
  v1::Case low = complete, high = complete;
  for (const auto& [end, value] : {std::pair{&low, &ends->low}, {&high, &ends->high}}) {
    const auto faults = apply_changes(*end, {change_of(key + ends->suffix, *value)});
    if (!faults.empty())
      return refused(fmt::format("at {}: {}", *value, faults.front().message()),
                     faults.front().permitted(), faults.front().remedy());
  }
  if (!ends->suffix.empty()) return std::nullopt;

  // An absolute range must be ascending and contain the value.
  const auto value = number_at(complete, key);
  if (!value && !has_value_at(complete, key))
    return refused("names a key that has no value, neither in the case nor in its card",
                   "keys that have a value",
                   fmt::format("give {} a value first, or take the range "
                               "out",
                               key));
  if (!value)
    return refused("is a table of several points, which no two ends describe",
                   "\"± 10 %\", \"± 5 K\" or \"0.5..2 times\"",
                   fmt::format("or name one point, e.g. {}[0]", key));
  const double from = number_at(low, key).value_or(*value);
  const double to = number_at(high, key).value_or(*value);
  const double margin = 1e-9 * std::abs(*value);
  if (!(from < to)) return refused("is no range: the smaller end comes first");
  if (from <= *value + margin && *value - margin <= to) return std::nullopt;
  const std::string unit = key_of(*field_at(complete, key)).unit();
  return refused(
      "does not hold the value of the case, " + quantity_text(*value, unit),
      "a range around the value",
      fmt::format("widen it, or give it relative to the value, as \"± 10 %\"; or take back "
                  "the change of {}",
                  key));
}

}  // namespace

std::optional<Range> parse_range(std::string_view text) {
  const std::string_view body = trimmed(text);
  for (const std::string_view sign : {"±", "+-", "+/-"})
    if (body.starts_with(sign)) return parse_symmetric(trimmed(body.substr(sign.size())));

  const auto dots = body.find("..");
  if (dots == std::string::npos) return std::nullopt;
  return parse_interval(trimmed(body.substr(0, dots)), trimmed(body.substr(dots + 2)));
}

std::vector<UncertainKey> uncertain_keys(const v1::Case& complete) {
  std::vector<UncertainKey> keys;
  std::set<std::string> seen;
  const auto add = [&](const std::string& key, const std::string& range, const char* origin) {
    if (const auto ends = parse_range(range); ends && seen.insert(key).second)
      keys.push_back({key, range, origin, *ends});
  };

  for (const v1::KeyRange& line : complete.uncertainty()) add(line.key(), line.range(), "case");
  for (const v1::KeyRange& line : complete.alloy().uncertainty())
    if (has_value_at(complete, "alloy." + line.key()))
      add("alloy." + line.key(), line.range(), "card");

  for (const KeyReference& row : reference(*v1::Case::descriptor()))
    if (!row.uncertainty.empty() && is_used(complete, row.path) && is_default(complete, row))
      add(row.path, row.uncertainty, "default");
  return keys;
}

std::vector<v1::Fault> uncertainty_faults(const v1::Case& complete) {
  std::vector<v1::Fault> faults;
  for (const v1::KeyRange& line : complete.uncertainty())
    if (auto fault = find_fault(complete, line.key(), line.range()))
      faults.push_back(std::move(*fault));
  return faults;
}

std::vector<v1::Fault> uncertainty_faults(const v1::Alloy& alloy) {
  v1::Case holder;
  *holder.mutable_alloy() = alloy;
  apply_defaults(*holder.mutable_alloy());
  for (const v1::KeyRange& line : alloy.uncertainty()) {
    v1::KeyRange& range = *holder.add_uncertainty();
    range.set_key("alloy." + line.key());
    range.set_range(line.range());
  }
  return uncertainty_faults(holder);
}

}  // namespace dccast::case_file
