#include "client/text/plant_units.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <regex>

#include "proto/case_file/case_file.hpp"

namespace dccast::client::render {
namespace {

std::string with_digits(double value, int digits) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

std::string place_in_words(const v1::Curve& curve, int point) {
  const double at = curve.at(point);
  switch (curve.abscissa()) {
    case v1::CAST_LENGTH:
    case v1::DISTANCE:
    case v1::GAP:
      return plant_number(1e3 * at) + " mm";
    case v1::TEMPERATURE:
      return plant_number(at) + " °C";
    case v1::LIQUID_FRACTION:
      return "liquid fraction " + plant_number(at);
    default:
      return plant_number(at) + " s";
  }
}

/// A number of a case file with its unit if it is a speed [m/s], which is shown in mm/min.
std::string shown_number(const std::string& number, bool speed) {
  constexpr std::size_t most_written = 10;
  const double value = std::strtod(number.c_str(), nullptr);
  if (speed) return with_digits(mm_per_min * value, 9) + " mm/min\"";
  const bool real = number.find_first_of(".eE") != std::string::npos;
  return real && number.size() > most_written ? with_digits(value, 9) : number;
}

}  // namespace

std::string plant_number(double value) {
  if (!std::isfinite(value)) return "-";
  if (std::abs(value) >= 1e4 && std::abs(value) < 1e15) return with_digits(std::round(value), 15);
  return with_digits(value == 0.0 ? 0.0 : value, 4);
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
  const std::string text = case_file::to_toml(input);
  // Only values, not numbers in a title: speeds, and numbers with too many digits.
  static const std::regex value(
      R"re(((?:= |\[|, )"?)([-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?)( m/s")?(?=[ ",\]\n]))re");
  std::string readable;
  auto rest = text.cbegin();
  for (std::sregex_iterator match(text.begin(), text.end(), value), end; match != end; ++match) {
    readable.append(rest, (*match)[0].first);
    rest = (*match)[0].second;
    readable += match->str(1) + shown_number(match->str(2), (*match)[3].matched);
  }
  return readable.append(rest, text.cend());
}

}  // namespace dccast::client::render
