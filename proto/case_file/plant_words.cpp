#include "proto/case_file/plant_words.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <regex>

#include <fmt/core.h>

#include "proto/case_file/case_file.hpp"

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

/// "45 -> 55 mm/min": first and last value of a table.
std::string range_text(double first, double last, const std::string& unit) {
  const std::string begin = plant_number(first), end = plant_number(last);
  return (begin == end ? begin : begin + " -> " + end) + " " + unit;
}

/// Cast length from the first to the last point of a speed table [m].
double travel(const v1::Curve& speed) {
  double length = 0.0;
  for (int i = 1; i < speed.at_size(); ++i)
    length += (speed.at(i) - speed.at(i - 1)) * (speed.value(i) + speed.value(i - 1)) / 2.0;
  return length;
}

/// " from 60 s to 200 s (over 117 mm)"; empty for one value.
std::string ramp_text(const v1::Curve& speed) {
  if (speed.at_size() < 2) return {};
  const bool by_length = speed.abscissa() == v1::CAST_LENGTH;
  const double first = speed.at(0), last = speed.at(speed.at_size() - 1);
  const auto place = [&](double at) { return by_length ? plant_mm(at) : plant_number(at) + " s"; };
  return " from " + place(first) + " to " + place(last) + " (over " +
         plant_mm(by_length ? last - first : travel(speed)) + ")";
}

std::string size_text(const v1::Case& c) {
  const std::string width = plant_number(2e3 * c.section().half_width_m());
  const v1::Curve& thickness = c.section().half_thickness_m();
  if (c.section().kind() == v1::Section::AXISYMMETRIC) return "billet of " + width + " mm diameter";
  if (c.section().kind() != v1::Section::QUARTER_SLAB || !has_values(thickness))
    return "section through " + width + " mm";
  return "slab " + width + " x " + plant_mm(2.0 * thickness.value(0));
}

/// Water of the whole perimeter at the first or last point of its tables [m3/s]; 0 for a section.
double total_water(const v1::Case& c, bool last) {
  const auto value = [last](const v1::Curve& curve) {
    return last ? *std::prev(curve.value().end()) : curve.value(0);
  };
  const v1::Curve& wide = c.schedule().water_flow_m2_per_s();
  const v1::Curve& given = c.schedule().narrow_water_flow_m2_per_s();
  const v1::Curve& thickness = c.section().half_thickness_m();
  const double half_width = c.section().half_width_m();
  if (c.section().kind() == v1::Section::AXISYMMETRIC)
    return 2.0 * std::numbers::pi * half_width * value(wide);
  if (c.section().kind() != v1::Section::QUARTER_SLAB || !has_values(thickness)) return 0.0;
  const v1::Curve& narrow = has_values(given) ? given : wide;
  return 4.0 * (half_width * value(wide) + thickness.value(0) * value(narrow));
}

std::string water_text(const v1::Case& c) {
  const v1::Curve& flow = c.schedule().water_flow_m2_per_s();
  if (!has_values(flow)) return {};
  std::string text =
      ", water " + range_text(litres_per_min_per_m * flow.value(0),
                              litres_per_min_per_m * *std::prev(flow.value().end()), "l/min/m");
  if (total_water(c, false) > 0.0)
    text += " = " + range_text(m3_per_hour * total_water(c, false),
                               m3_per_hour * total_water(c, true), "m3/h");
  return text;
}

}  // namespace

std::string plant_number(double value) {
  if (!std::isfinite(value)) return "-";
  if (std::abs(value) >= 1e4 && std::abs(value) < 1e15) return with_digits(std::round(value), 15);
  return with_digits(value == 0.0 ? 0.0 : value, 4);
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
  const v1::Curve& speed = c.schedule().casting_speed_m_per_s();
  if (has_values(speed))
    text += ", speed " +
            range_text(mm_per_min * speed.value(0), mm_per_min * *std::prev(speed.value().end()),
                       "mm/min") +
            ramp_text(speed);
  return text + water_text(c);
}

}  // namespace dccast::case_file
