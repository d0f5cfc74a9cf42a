#include "proto/case_file/slab_recipe.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>
#include <optional>
#include <sstream>
#include <utility>

#include <fmt/core.h>

#include "proto/case_file/alloy_cards.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/plant_words.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/case_file/shipped.hpp"
#include "proto/case_file/text_checks.hpp"

namespace dccast::case_file {
namespace {

constexpr const char* standard = "start-3d";
constexpr const char* of_billets = "start-billet";

/// A number without trailing zeros, "0.285".
std::string short_number(double value, int digits = 4) {
  return fmt::format("{:.{}g}", value, digits);
}

/// Both ends of a range; equal if one value was given.
struct FigureRange {
  double first = 0.0, last = 0.0;

  std::string text(double factor) const {
    const std::string begin = short_number(factor * first), end = short_number(factor * last);
    return begin == end ? begin : begin + " -> " + end;
  }
};

/// "45..55mm/min" as two texts with the unit; of "1320x570mm" the separator is "x".
std::pair<std::string, std::string> parts(const std::string& text, const std::string& separator) {
  const auto at = text.find(separator);
  if (at == std::string::npos) return {text, text};
  std::string first = text.substr(0, at), last = text.substr(at + separator.size());
  const auto has_unit = [](char c) {
    return std::string("0123456789.+- ").find(c) == std::string::npos;
  };
  const auto unit = std::find_if(last.begin(), last.end(), has_unit);
  if (std::none_of(first.begin(), first.end(), has_unit)) first.append(unit, last.end());
  return {std::move(first), std::move(last)};
}

/// Value in this unit; empty if the text is not such a quantity.
std::optional<FigureRange> range_of(const std::string& text, const std::string& separator,
                                    const std::string& unit) {
  const auto [first, last] = parts(text, separator);
  const auto begin = parse_quantity(first, unit).value;
  const auto end = parse_quantity(last, unit).value;
  if (!begin || !end || *begin <= 0.0 || *end <= 0.0) return std::nullopt;
  return FigureRange{*begin, *end};
}

/// A recipe in SI units.
struct Slab {
  FigureRange size;    ///< width and thickness; of a billet the diameter twice [m]
  bool round = false;  ///< a billet
  std::string alloy{};
  std::optional<FigureRange> speed{};  ///< [m/s]
  std::optional<FigureRange> flow{};   ///< per metre of perimeter [m2/s]
  std::optional<FigureRange> total{};  ///< of the whole perimeter, where it was given so [m3/s]

  double perimeter() const {
    return round ? std::numbers::pi * size.first : 2.0 * (size.first + size.last);
  }
  double area() const {
    return round ? std::numbers::pi * size.first * size.first / 4.0 : size.first * size.last;
  }
  /// "slab 1320 x 570 mm", "billet 203 mm"
  std::string name() const {
    const std::string width = short_number(1e3 * size.first) + " mm";
    if (round) return "billet " + width;
    return fmt::format("slab {} x {} mm", short_number(1e3 * size.first),
                       short_number(1e3 * size.last));
  }
};

/// Lengths for which the rules of a start are meant [m].
struct Domain {
  const char* name;
  double least, most;
};
constexpr Domain widths{"width", 0.4, 2.6}, thicknesses{"thickness", 0.2, 0.75},
    diameters{"diameter", 0.15, 0.5};

void check_domain(const std::string& given, double length, const Domain& domain,
                  std::vector<std::string>& faults) {
  if (length >= domain.least && length <= domain.most) return;
  faults.push_back(fmt::format(
      "{}: a {} of {} mm; the rules of `dccast new` hold from {} to {} mm (docs/quarter-slab.md). "
      "For another size change a case that it wrote",
      given, domain.name, short_number(1e3 * length), short_number(1e3 * domain.least),
      short_number(1e3 * domain.most)));
}

void read_diameter(const SlabRecipe& recipe, Slab& slab, std::vector<std::string>& faults) {
  slab.round = true;
  const auto diameter = parse_quantity(recipe.billet, "m").value;
  const std::string given = "--billet \"" + recipe.billet + "\"";
  if (!diameter || *diameter <= 0.0)
    return faults.push_back(given + ": a diameter is expected, e.g. 203mm");
  slab.size = {*diameter, *diameter};
  check_domain(given, *diameter, diameters, faults);
}

void read_size(const SlabRecipe& recipe, Slab& slab, std::vector<std::string>& faults) {
  if (!recipe.billet.empty()) return read_diameter(recipe, slab, faults);
  constexpr std::string_view times = "×";
  std::string text = recipe.slab;
  if (const auto sign = text.find(times); sign != std::string::npos)
    text.replace(sign, times.size(), "x");
  const auto size = range_of(text, "x", "m");
  const std::string given = "--slab \"" + recipe.slab + "\"";
  if (!size || text.find('x') == std::string::npos)
    return faults.push_back(given + ": width x thickness with a unit is expected, e.g. 1320x570mm");

  // A plant names either side first.
  slab.size = {std::max(size->first, size->last), std::min(size->first, size->last)};
  check_domain(given, slab.size.first, widths, faults);
  check_domain(given, slab.size.last, thicknesses, faults);
}

void read_water(const SlabRecipe& recipe, Slab& slab, std::vector<std::string>& faults) {
  if (recipe.water.empty()) return;
  slab.flow = range_of(recipe.water, "..", "m2/s");
  if (slab.flow) return;
  slab.total = range_of(recipe.water, "..", "m3/s");
  if (slab.total && slab.perimeter() > 0.0)
    slab.flow =
        FigureRange{slab.total->first / slab.perimeter(), slab.total->last / slab.perimeter()};
  else if (!slab.total)
    faults.push_back("--water \"" + recipe.water +
                     "\": a flow in all or per metre of perimeter is expected, e.g. 25..45m3/h or "
                     "90..180l/min/m");
}

/// Cards have names in lower case; a card of one's own is a file, "my-alloy.toml".
void read_alloy(const SlabRecipe& recipe, Slab& slab, std::vector<std::string>& faults) {
  slab.alloy = recipe.alloy;
  if (recipe.alloy.ends_with(".toml")) return;
  std::ranges::transform(slab.alloy, slab.alloy.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });

  const auto alloys = alloy_names();
  if (!slab.alloy.empty() && std::ranges::find(alloys, slab.alloy) == alloys.end()) {
    const std::string near = nearest(slab.alloy, alloys);
    faults.push_back("--alloy " + recipe.alloy + ": no such card; " +
                     (near.empty() ? "see `dccast alloys`" : "did you mean " + near + "?"));
  }
}

Slab read_recipe(const SlabRecipe& recipe, std::vector<std::string>& faults) {
  Slab slab;
  read_size(recipe, slab, faults);
  read_alloy(recipe, slab, faults);
  if (!recipe.speed.empty() && !(slab.speed = range_of(recipe.speed, "..", "m/s")))
    faults.push_back("--speed \"" + recipe.speed + "\": a speed is expected, e.g. 45..55mm/min");
  read_water(recipe, slab, faults);
  return slab;
}

/// The lines of a shipped case, some of which are replaced.
class CaseText {
public:
  explicit CaseText(const std::string& text) {
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) lines_.push_back(line);
  }

  /// Value of a key as written in the file, quotes included.
  std::string value(const std::string& key) const {
    for (const std::string& line : lines_)
      if (line.starts_with(key + " = ")) {
        const auto begin = key.size() + 3;
        return std::string(
            trimmed(std::string_view(line).substr(begin, line.find(" #", begin) - begin)));
      }
    return {};
  }

  /// Replaces `key = from` in every line; an empty `from` matches any value.
  void replace(const std::string& key, const std::string& from, const std::string& to,
               const std::string& comment = {}) {
    for (std::string& line : lines_)
      if (line.starts_with(key + " = " + from))
        line = key + " = " + to + (comment.empty() ? "" : " # " + comment);
  }

  /// The comment at the top of the file.
  void replace_head(const std::string& head) {
    const auto end =
        std::ranges::find_if(lines_, [](const auto& line) { return !line.starts_with('#'); });
    lines_.erase(lines_.begin(), end);
    lines_.insert(lines_.begin(), head);
  }

  std::string text() const {
    std::string text;
    for (const std::string& line : lines_) text += line + "\n";
    return text;
  }

private:
  std::vector<std::string> lines_;
};

/// A table that is constant, then rises or falls evenly, then is constant again.
struct Ramp {
  double begin = 0.0, end = 0.0;  ///< [s]
  FigureRange value;
};

/// A table of a shipped case; of a single value a ramp of no length.
Ramp ramp_in(const v1::Curve& table) {
  const FigureRange value{table.value(0), *table.value().rbegin()};
  if (table.at_size() < 2) return {.value = value};
  return {table.at(0), *table.at().rbegin(), value};
}

/// @param factor  from SI to the unit
std::string table_of(const Ramp& ramp, double factor, const std::string& unit) {
  constexpr int digits = 6;  // the sum over the perimeter is the one given
  const auto quoted = [&](double value) {
    return fmt::format("\"{} {}\"", short_number(factor * value, digits), unit);
  };
  const std::string first = quoted(ramp.value.first), last = quoted(ramp.value.last);
  if (first == last || ramp.end <= ramp.begin) return last;
  return fmt::format("[[\"{:.0f} s\", {}], [\"{:.0f} s\", {}]]", ramp.begin, first, ramp.end, last);
}

const shipped::ShippedText& nearest_case(const Slab& slab) {
  const auto& cases = shipped::case_templates();
  if (slab.round) return *shipped::find(cases, of_billets);
  const std::string& alloy = slab.alloy;
  const auto* own = shipped::find(cases, std::string(standard) + "-" + alloy);
  return own != nullptr ? *own : *shipped::find(cases, standard);
}

void set_size(const Slab& slab, CaseText& text) {
  const std::string width = text.value("half_width"), thickness = text.value("half_thickness");
  const auto metres = [](double value) { return "\"" + short_number(value) + " m\""; };
  if (slab.round) {
    const double radius = slab.size.first / 2.0;
    text.replace("x", width, metres(radius));
    text.replace("x", "\"0.05 m\"", metres(radius / 2.0));  // the monitor "half radius"
    return text.replace("half_width", "", metres(radius), "[G] radius");
  }

  const std::string half_width = metres(slab.size.first / 2.0);
  const std::string half_thickness = metres(slab.size.last / 2.0);
  for (const char* key : {"x", "y"}) {
    text.replace(key, width, half_width);
    text.replace(key, thickness, half_thickness);
  }
  text.replace("half_width", "", half_width, "[G] half the length of the wide face");
  text.replace("half_thickness", "", half_thickness, "[G]");
}

bool differ(double a, double b) {
  constexpr double rounding = 1e-9;
  return std::abs(a - b) > rounding * std::max(std::abs(a), std::abs(b));
}

/// To a multiple of a step, as a plant sets it.
double rounded(double value, double step) {
  return step * std::round(value / step);
}

v1::Case read_shipped(const shipped::ShippedText& shipped) {
  v1::Case description;
  read_text(shipped.text, shipped.name, description);
  return description;
}

/// Size of the slab of a shipped case.
Slab slab_in(const v1::Section& section, bool round) {
  const double width = 2.0 * section.half_width_m();
  return {.size = {width, round ? width : 2.0 * section.half_thickness_m().value(0)},
          .round = round};
}

/// Speed of a slab. The sump is as deep as speed times thickness squared: at a speed that falls
/// with the thickness it keeps its proportion to it. A thinner slab is cast no faster: the shell
/// over its block takes the same time, and AA5182 bleeds out there at 58 instead of 50 mm/min. A
/// ramp begins and ends at the cast lengths of the shipped case, since these decide how much of the
/// butt sees which water.
Ramp speed_of(const Slab& slab, const Slab& base, const Ramp& shipped) {
  const auto [first, last] = shipped.value;
  const double factor = std::min(base.size.last / slab.size.last, 1.0);

  Ramp ramp;
  constexpr double step = 0.5 / mm_per_min;
  ramp.value =
      slab.speed.value_or(FigureRange{rounded(factor * first, step), rounded(factor * last, step)});
  const double before = shipped.begin * first;
  const double length = (shipped.end - shipped.begin) * (first + last) / 2.0;
  ramp.begin = before / ramp.value.first;
  ramp.end = ramp.begin + 2.0 * length / (ramp.value.first + ramp.value.last);
  return ramp;
}

/// Water of a slab, on the ramp of its speed. It carries the heat that the metal brings, speed
/// times area per perimeter. The first water is never more than that of the shipped case, since it
/// decides how the butt is wetted: a thinner butt of AA5182 with all of it curls off its block so
/// early that its shell melts through.
Ramp water_of(const Slab& slab, const Slab& base, const Ramp& shipped, const Ramp& speed,
              const Ramp& shipped_speed) {
  constexpr double least_at_first = 60e-3 / 60.0;             // [m2/s] [A]
  constexpr FigureRange usual{150e-3 / 60.0, 250e-3 / 60.0};  // [m2/s], docs/alloys.md
  Ramp ramp = shipped;
  ramp.begin = speed.begin, ramp.end = speed.end;
  if (slab.flow) {
    ramp.value = *slab.flow;
  } else if (shipped.end > shipped.begin) {
    const double heat = speed.value.last * slab.area() / slab.perimeter();
    const double heat_of_shipped = shipped_speed.value.last * base.area() / base.perimeter();
    const double share = heat / heat_of_shipped;

    const double first =
        std::clamp(share * shipped.value.first, std::min(least_at_first, shipped.value.first),
                   shipped.value.first);
    const double last = std::clamp(share * shipped.value.last, usual.first, usual.last);

    constexpr double step = 1.0 / litres_per_min_per_m;
    ramp.value = {rounded(first, step), rounded(last, step)};
  }
  return ramp;
}

std::string head_of(const SlabRecipe& recipe, const Slab& slab, const std::string& base) {
  std::string command =
      slab.round ? "dccast new --billet " + recipe.billet : "dccast new --slab " + recipe.slab;
  for (const auto& [option, value] : {std::pair(" --alloy ", recipe.alloy),
                                      {" --speed ", recipe.speed},
                                      {" --water ", recipe.water}})
    if (!value.empty()) command += option + value;
  return fmt::format(
      "# Start of casting of a {}, a {} of it. Written by\n#   {}\n#\n"
      "# Marks: [G] given there. Everything else is that of {}.toml: [P] printed in the paper, [C] "
      "computed, [L] public\n# literature, [A] assumption. What differs most between plants: hold, "
      "filling, casting_temperature, block_above_water, the water\n"
      "# line (cooling.water.from) with the zones above it, and the bottom block. Every key, its "
      "unit, range and default: `dccast schema`.",
      slab.name(), slab.round ? "half section" : "quarter", command, base);
}

}  // namespace

NewCase new_case(const SlabRecipe& recipe) {
  NewCase made;
  const Slab slab = read_recipe(recipe, made.faults);
  if (!made.faults.empty()) return made;

  // The shipped case whose alloy is nearest is the text that the recipe changes.
  const shipped::ShippedText& base = nearest_case(slab);
  CaseText text(base.text);
  const std::string alloy = slab.alloy.empty() ? text.value("card") : "\"" + slab.alloy + "\"";
  const std::string slab_of_card =
      fmt::format("{} of {}", slab.name(), alloy.substr(1, alloy.size() - 2));

  text.replace_head(head_of(recipe, slab, base.name));
  text.replace("title", "", "\"Start of a " + slab_of_card + "\"");

  if (!slab.alloy.empty())
    text.replace("card", "", alloy,
                 base.name == standard || slab.round
                     ? "[G]; temperatures of the metal are those of " + base.name
                     : "[G]");
  set_size(slab, text);

  const v1::Case description = read_shipped(base);
  const Slab shipped_slab = slab_in(description.section(), slab.round);
  const Ramp shipped_speed = ramp_in(description.schedule().casting_speed_m_per_s()),
             shipped_water = ramp_in(description.schedule().water_flow_m2_per_s());
  const Ramp speed = speed_of(slab, shipped_slab, shipped_speed);
  const Ramp water = water_of(slab, shipped_slab, shipped_water, speed, shipped_speed);
  const std::string by_rule = "[A] by the size, docs/quarter-slab.md",
                    lengths = "; the ramp has the cast lengths of " + base.name;

  if (slab.speed || differ(speed.value.last, shipped_speed.value.last))
    text.replace("casting_speed", "", table_of(speed, mm_per_min, "mm/min"),
                 (slab.speed ? "[G]" : by_rule) + lengths);

  const std::string perimeter = short_number(slab.perimeter()) + " m";
  made.summary =
      slab_of_card + ", perimeter " + perimeter + "; " + speed.value.text(mm_per_min) + " mm/min";
  const FigureRange whole{water.value.first * slab.perimeter(),
                          water.value.last * slab.perimeter()};
  const std::string total = whole.text(m3_per_hour) + " m3/h";
  made.summary +=
      fmt::format("; water {} = {} l/min/m", total, water.value.text(litres_per_min_per_m));
  if (slab.flow || differ(water.value.last, shipped_water.value.last) ||
      differ(water.end, shipped_water.end))
    text.replace("water_flow", "", table_of(water, litres_per_min_per_m, "l/min/m"),
                 (slab.flow ? "[G] " : by_rule + ": ") + total + " over a perimeter of " +
                     perimeter + lengths);

  made.text = text.text();
  return made;
}

}  // namespace dccast::case_file
