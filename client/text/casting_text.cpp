#include "client/text/casting_text.hpp"

#include <algorithm>
#include <numbers>

#include "client/text/plant_units.hpp"

namespace dccast::client::render {
namespace {

constexpr double m3_per_hour = 3600.0;  // [(m3/h)/(m3/s)]

bool has_values(const v1::Curve& curve) {
  return curve.value_size() > 0 && curve.value_size() == curve.at_size();
}

/// "45 -> 55 mm/min", of a table its first and last value.
std::string range_text(double first, double last, const std::string& unit) {
  const std::string begin = plant_number(first), end = plant_number(last);
  return (begin == end ? begin : begin + " -> " + end) + " " + unit;
}

/// From the first point of a table of the casting speed to its last one [m].
double travel(const v1::Curve& speed) {
  double length = 0.0;
  for (int i = 1; i < speed.at_size(); ++i)
    length += (speed.at(i) - speed.at(i - 1)) * (speed.value(i) + speed.value(i - 1)) / 2.0;
  return length;
}

/// " from 60 s to 200 s (over 117 mm)"; empty for one value.
std::string ramp_text(const v1::Curve& speed) {
  if (speed.at_size() < 2) return {};
  const double first = speed.at(0), last = speed.at(speed.at_size() - 1);
  if (speed.abscissa() == v1::CAST_LENGTH)
    return " from " + plant_number(1e3 * first) + " mm to " + plant_number(1e3 * last) +
           " mm (over " + plant_number(1e3 * (last - first)) + " mm)";
  return " from " + plant_number(first) + " s to " + plant_number(last) + " s (over " +
         plant_number(1e3 * travel(speed)) + " mm)";
}

std::string size_text(const v1::Case& c) {
  const double width_mm = 2e3 * c.section().half_width_m();
  const v1::Curve& thickness = c.section().half_thickness_m();
  if (c.section().kind() == v1::Section::AXISYMMETRIC)
    return "billet of " + plant_number(width_mm) + " mm diameter";
  if (c.section().kind() != v1::Section::QUARTER_SLAB || !has_values(thickness))
    return "section through " + plant_number(width_mm) + " mm";
  return "slab " + plant_number(width_mm) + " x " + plant_number(2e3 * thickness.value(0)) + " mm";
}

/// Water of the whole perimeter at the first or last point of its tables [m3/s]; 0 for a section,
/// which has none.
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

}  // namespace dccast::client::render
