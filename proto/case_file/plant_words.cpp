#include "proto/case_file/plant_words.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <iterator>
#include <numbers>
#include <regex>
#include <vector>

#include <fmt/core.h>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/case_file/schedule.hpp"

namespace dccast::case_file {
namespace {

std::string with_digits(double value, int digits) {
  return fmt::format("{:.{}g}", value, digits);
}

std::string place_in_words(const v1::Curve& curve, int point) {
  const double at = curve.at(point);
  switch (curve.abscissa()) {
    case v1::CAST_LENGTH:
    case v1::DISTANCE:
    case v1::GAP:
      return plant_mm(at);
    case v1::TEMPERATURE:
      return plant_number(at) + " °C";
    case v1::LIQUID_FRACTION:
      return "liquid fraction " + plant_number(at);
    default:
      return plant_number(at) + " s";
  }
}

/// A number of a case file, in plant units if it is a speed or a flow of water per metre.
/// @param unit  as in the file, with the quote after it; empty for other numbers
std::string shown_number(const std::string& number, const std::string& unit) {
  constexpr std::size_t most_written = 10;
  const double value = std::strtod(number.c_str(), nullptr);
  if (unit == " m/s\"") return with_digits(mm_per_min * value, 9) + " mm/min\"";
  if (unit == " m2/s\"") return with_digits(litres_per_min_per_m * value, 9) + " l/min/m\"";
  const bool real = number.find_first_of(".eE") != std::string::npos;
  return real && number.size() > most_written ? with_digits(value, 9) : number;
}

bool has_values(const v1::Curve& curve) {
  return curve.value_size() > 0 && curve.value_size() == curve.at_size();
}

/// How a quantity changes over the casting.
struct Change {
  std::vector<double> turns;  ///< the first value, those between a rise and a fall, and the last
  Instant begin, end;         ///< of the change

  Change(const std::vector<Instant>& instants, const std::function<double(const Instant&)>& value) {
    std::vector<double> values;
    std::ranges::transform(instants, std::back_inserter(values), value);
    for (const double v : values) add(v);

    const auto is_other_than = [](double reference) {
      return [reference](double v) { return !is_same(v, reference); };
    };
    const auto first = std::ranges::find_if(values, is_other_than(values.front()));
    if (first == values.end()) return;
    begin = instants[static_cast<std::size_t>(first - values.begin()) - 1];
    const auto last = std::find_if(values.rbegin(), values.rend(), is_other_than(values.back()));
    end = instants[static_cast<std::size_t>(last.base() - values.begin())];
  }

private:
  static bool is_same(double a, double b) { return std::abs(a - b) <= 1e-9 * std::abs(b); }

  void add(double value) {
    if (!turns.empty() && is_same(value, turns.back())) return;
    const bool goes_on =
        turns.size() > 1 && (value > turns.back()) == (turns.back() > turns[turns.size() - 2]);
    if (goes_on)
      turns.back() = value;
    else
      turns.push_back(value);
  }
};

/// "45 -> 55 mm/min", "45 -> 36 -> 55 mm/min": the values at which a quantity turns.
std::string range_text(const Change& change, double factor, const std::string& unit) {
  constexpr std::size_t most = 5;
  const std::size_t count = change.turns.size();
  std::string text;
  for (std::size_t i = 0; i < count; ++i) {
    if (count > most && i > 1 && i + 2 < count) continue;
    text += (i == 0 ? "" : " -> ") + plant_number(factor * change.turns[i]);
    if (count > most && i == 1) text += " -> ...";
  }
  return text + " " + unit;
}

/// " from 60 s to 200 s (over 117 mm)"; empty where nothing changes.
std::string ramp_text(const Change& change, bool by_length) {
  if (change.turns.size() < 2) return {};
  const auto place = [&](const Instant& at) {
    return by_length ? plant_mm(at.cast_length_m) : plant_number(at.time_s) + " s";
  };
  return " from " + place(change.begin) + " to " + place(change.end) + " (over " +
         plant_mm(change.end.cast_length_m - change.begin.cast_length_m) + ")";
}

std::string size_text(const v1::Case& c) {
  const std::string width = plant_number(2e3 * c.section().half_width_m());
  const v1::Curve& thickness = c.section().half_thickness_m();
  if (c.section().kind() == v1::Section::AXISYMMETRIC) return "billet of " + width + " mm diameter";
  if (c.section().kind() != v1::Section::QUARTER_SLAB || !has_values(thickness))
    return "section through " + width + " mm";
  return "slab " + width + " x " + plant_mm(2.0 * thickness.value(0));
}

/// Water of the whole perimeter per that of each face [m]: m3/s for m2/s; zero for a section.
struct Perimeter {
  double wide_m = 0.0, narrow_m = 0.0;
};

Perimeter perimeter_of(const v1::Section& section) {
  const double half_width = section.half_width_m();
  if (section.kind() == v1::Section::AXISYMMETRIC) return {2.0 * std::numbers::pi * half_width};
  if (section.kind() != v1::Section::QUARTER_SLAB || !has_values(section.half_thickness_m()))
    return {};
  return {4.0 * half_width, 4.0 * section.half_thickness_m().value(0)};
}

/// ", pulsed 2 of 4 s until 30 s"; empty for water that runs without a break.
std::string pulse_text(const v1::Water& water) {
  if (water.pulse_period_s() <= 0.0 || water.pulse_end_s() <= water.start_s()) return {};
  return ", pulsed " + plant_number(water.pulse_share() * water.pulse_period_s()) + " of " +
         plant_number(water.pulse_period_s()) + " s until " + plant_number(water.pulse_end_s()) +
         " s";
}

std::string water_text(const v1::Case& c, const CastingSchedule& schedule,
                       std::vector<Instant> instants) {
  const PlannedQuantity wide = schedule.water_flow(Face::wide);
  const PlannedQuantity narrow = schedule.water_flow(Face::narrow);
  const v1::Water& water = schedule.water(Face::wide);
  if (!has_values(wide.table)) return {};
  if (!water.enabled()) return ", no water";

  std::erase_if(instants, [&](const Instant& at) { return at.time_s < water.start_s(); });
  const Change flow(instants, [&](const Instant& at) { return wide.at(at); });
  std::string text = ", water " + range_text(flow, litres_per_min_per_m, "l/min/m");

  const Perimeter perimeter = perimeter_of(c.section());
  const Change total(instants, [&](const Instant& at) {
    return perimeter.wide_m * wide.at(at) + perimeter.narrow_m * narrow.at(at);
  });
  if (perimeter.wide_m > 0.0) text += " = " + range_text(total, m3_per_hour, "m3/h");
  return text + pulse_text(water);
}

}  // namespace

std::string outcome_word(v1::LineCasting::Outcome outcome) {
  if (outcome == v1::LineCasting::UNKNOWN) return "";
  std::string word = v1::LineCasting::Outcome_Name(outcome);
  for (char& c : word) c = c == '_' ? '-' : static_cast<char>(c - 'A' + 'a');
  return word;
}

std::optional<v1::LineCasting::Outcome> outcome_of(const std::string& word) {
  for (int i = v1::LineCasting::SOUND; v1::LineCasting::Outcome_IsValid(i); ++i)
    if (const auto outcome = static_cast<v1::LineCasting::Outcome>(i);
        outcome_word(outcome) == word)
      return outcome;
  return std::nullopt;
}

std::string outcome_words(v1::LineCasting::Outcome first) {
  std::string words;
  for (int i = first; v1::LineCasting::Outcome_IsValid(i); ++i)
    words += (words.empty() ? "" : ", ") + outcome_word(static_cast<v1::LineCasting::Outcome>(i));
  return words;
}

std::string plant_number(double value) {
  if (!std::isfinite(value)) return "-";
  if (std::abs(value) >= 1e4 && std::abs(value) < 1e15) return with_digits(std::round(value), 15);
  return with_digits(value == 0.0 ? 0.0 : value, 4);
}

std::string flow_per_metre_hint(const v1::Section& section, const std::string& flow) {
  const auto m3_per_s = parse_quantity(flow, "m3/s").value;
  if (!m3_per_s) return {};
  const Perimeter perimeter = perimeter_of(section);
  const double whole_m = perimeter.wide_m + perimeter.narrow_m;
  if (!(whole_m > 0.0))
    return flow + " is the flow of all faces; divide it by their perimeter, e.g. \"180 l/min/m\"";
  return flow + " is the flow of all faces; over the perimeter of " + plant_number(whole_m) +
         " m it is \"" + plant_number(litres_per_min_per_m * *m3_per_s / whole_m) + " l/min/m\"";
}

std::string plant_mm(double metres) {
  return plant_number(1e3 * metres) + " mm";
}

std::string curve_in_words(const v1::Curve& curve, double factor, const std::string& unit) {
  const int count = std::min(curve.at_size(), curve.value_size());
  const auto value = [&](int i) { return plant_number(factor * curve.value(i)) + " " + unit; };
  if (curve.value_size() == 0) return "-";
  if (count < 2) return value(0);
  std::string text = value(0) + " to " + place_in_words(curve, 0);
  for (int i = 1; i < count; ++i) {
    const bool level = curve.value(i) == curve.value(i - 1);
    text += level ? ", held to " + place_in_words(curve, i)
                  : ", then to " + value(i) + " at " + place_in_words(curve, i);
  }
  return text;
}

std::string readable_toml(const v1::Case& input) {
  const std::string text = to_toml(input);
  // Converts values only, not numbers in a title: speeds, water, and numbers with too many digits.
  static const std::regex value(
      R"re(((?:= |\[|, )"?)([-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?)( m2?/s")?(?=[ ",\]\n]))re");
  std::string readable;
  auto rest = text.cbegin();
  for (std::sregex_iterator match(text.begin(), text.end(), value), end; match != end; ++match) {
    readable.append(rest, (*match)[0].first);
    rest = (*match)[0].second;
    readable += match->str(1) + shown_number(match->str(2), match->str(3));
  }
  return readable.append(rest, text.cend());
}

std::string casting_summary(const v1::Case& c) {
  std::string text = size_text(c);
  if (!c.alloy().card().empty()) text += " of " + c.alloy().card();

  const CastingSchedule schedule(c);
  const std::vector<Instant> instants = schedule.instants();
  const PlannedQuantity speed = schedule.casting_speed();
  if (has_values(speed.table)) {
    std::vector<Instant> moving = instants;
    std::erase_if(moving, [](const Instant& at) { return at.time_s < 0.0; });
    const Change change(moving, [&](const Instant& at) { return speed.at(at); });
    text += ", speed " + range_text(change, mm_per_min, "mm/min") +
            ramp_text(change, speed.changes_by_length());
  }
  return text + water_text(c, schedule, instants);
}

}  // namespace dccast::case_file
