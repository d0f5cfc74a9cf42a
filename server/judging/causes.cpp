#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>

#include "server/judging/comparison.hpp"
#include "server/judging/judgement.hpp"

namespace dccast::judging {
namespace {

constexpr double least_share = 0.03;  ///< of a figure's scale, see find_causes()
constexpr std::size_t most_causes = 3;

/// How a difference of a figure is put into words.
enum class Wording {
  flow,     ///< "less heat ... (-22 %)", summed over the places where it differs
  level,    ///< "shell ... 62 -> 71 mm", where it differs most
  shell,    ///< as a level, where the section is not solid through, as the butt is
  contact,  ///< "contact ... 8 s longer", otherwise as a flow
};

using Step = v1::StepReport;

/// A figure of the step report. Of the figures per metre of face and of the whole quarter, the one
/// that a run does not have is zero.
struct Figure {
  Wording wording;
  const char* in_slab;       ///< its name in a quarter slab
  const char* in_section;    ///< in a section; null: it has none
  const char* slab_unit;     ///< SI
  const char* section_unit;  ///< SI
  double (*value)(const Step&);
};

constexpr std::array figures{
    Figure{Wording::flow, "heat through the wide face", "heat through the side", "W", "W/m",
           [](const Step& s) { return s.section().side_heat(); }},
    Figure{Wording::flow, "heat through the narrow face", nullptr, "W", "W/m",
           [](const Step& s) { return s.section().narrow_heat(); }},
    Figure{Wording::flow, "heat into the block", "heat into the block", "W", "W/m",
           [](const Step& s) { return s.section().bottom_heat(); }},
    Figure{Wording::flow, "heat of the metal", "heat of the metal", "W", "W/m",
           [](const Step& s) { return s.section().metal_heat() + s.section().level_heat(); }},
    Figure{Wording::contact, "contact with the block", "contact with the block", "m2", "m",
           [](const Step& s) { return s.contact_area_m2() + s.contact_length_m(); }},
    Figure{Wording::shell, "shell at the water line", "shell at the water line", "m", "m",
           [](const Step& s) { return s.shell_at_water_line_m(); }},
    Figure{Wording::level, "shell over the block", "shell over the block", "m", "m",
           [](const Step& s) { return s.bottom_shell_m(); }},
    Figure{Wording::level, "depth of the sump", "depth of the sump", "m", "m",
           [](const Step& s) { return s.sump_depth_m(); }},
    Figure{Wording::level, "wetted share of the wide face", "wetted share of the side", "1", "1",
           [](const Step& s) { return s.wetted_share(); }},
    Figure{Wording::level, "block surface", "block surface", "degC", "degC",
           [](const Step& s) { return s.block_temperature_c(); }},
};

/// A figure of both runs along their course.
struct Pair {
  const Course& course;
  std::vector<double> first;
  std::vector<double> other;
  double from = -std::numeric_limits<double>::infinity();  ///< place [s] or [m] of the first
                                                           ///< difference that counts

  std::size_t size() const { return first.size(); }

  /// Other less first; 0 where one of them is not known, and where they do not compare.
  double difference(std::size_t i) const {
    if (course.places[i] < from) return 0.0;
    const double d = other[i] - first[i];
    return std::isfinite(d) ? d : 0.0;
  }

  /// Half of the course on either side of a place [s] or [m].
  double weight(std::size_t i) const {
    const auto& places = course.places;
    const std::size_t before = i == 0 ? 0 : i - 1;
    const std::size_t after = std::min(i + 1, places.size() - 1);
    return 0.5 * (places[after] - places[before]);
  }

  /// Sum over places with their weights. @param term  (place)
  template <class Term>
  double sum(std::size_t begin, std::size_t end, Term term) const {
    double total = 0.0;
    for (std::size_t i = begin; i < end; ++i) total += weight(i) * term(i);
    return total;
  }

  double largest_difference(std::size_t end) const {
    double most = 0.0;
    for (std::size_t i = 0; i < end; ++i) most = std::max(most, std::abs(difference(i)));
    return most;
  }

  /// Range of the two, with zero unless both are far from it.
  double scale() const {
    double low = 0.0;
    double high = 0.0;
    for (const auto* values : {&first, &other})
      for (const double value : *values) {
        if (!std::isfinite(value)) continue;
        low = std::min(low, value);
        high = std::max(high, value);
      }
    return high - low;
  }
};

/// From the middle of a section to its side [m], where that is nearest.
double half_thickness_m(const v1::Section& section) {
  double half = section.half_width_m();
  for (const double value : section.half_thickness_m().value()) half = std::min(half, value);
  return half > 0.0 ? half : std::numeric_limits<double>::infinity();
}

std::vector<double> values_along(const Course& course, const Figure& figure, const JudgedRun& run) {
  constexpr double solid_through = 0.98;
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  const double limit = figure.wording == Wording::shell
                           ? solid_through * half_thickness_m(run.description.section())
                           : std::numeric_limits<double>::infinity();

  std::vector<double> values;
  for (const Step& step : run.steps) {
    const double value = figure.value(step);
    values.push_back(value < limit ? value : unknown);
  }
  return along(course, run, values);
}

/// Before the block starts, castings that were held for different times are of different age: one
/// has hardly been filled where the other one has a shell. [s]
double comparable_from(const Course& course, const JudgedRun& first, const JudgedRun& other) {
  constexpr double same_hold_s = 1.0;
  const double difference_s =
      other.description.schedule().hold_s() - first.description.schedule().hold_s();
  const bool same_age = course.by_length || std::abs(difference_s) < same_hold_s;
  return same_age ? -std::numeric_limits<double>::infinity() : 0.0;
}

/// First place from which on the difference has reached a share of its value at the end.
std::size_t first_reached(const Pair& curl, double share) {
  const double end = curl.difference(curl.size() - 1);
  std::size_t place = curl.size() - 1;
  while (place > 0 && curl.difference(place - 1) * end >= share * end * end) --place;
  return place;
}

std::string flow_text(const char* name, const Pair& pair, std::size_t onset) {
  constexpr double acts = 0.25;         // of the largest difference
  constexpr double one_sided = 0.7;     // else the difference changes its sign
  constexpr double at_the_edge = 0.05;  // of the course
  const Course& course = pair.course;

  // The flow differs until the difference has become small for good.
  std::size_t end = pair.size();
  const double most = pair.largest_difference(end);
  while (end > onset + 1 && std::abs(pair.difference(end - 1)) < acts * most) --end;

  const double net = pair.sum(onset, end, [&](std::size_t i) { return pair.difference(i); });
  const double gross =
      pair.sum(onset, end, [&](std::size_t i) { return std::abs(pair.difference(i)); });
  const double before = pair.sum(onset, end, [&](std::size_t i) {
    return std::isfinite(pair.first[i]) ? pair.first[i] : 0.0;
  });
  if (std::abs(net) < one_sided * gross || std::abs(net) < least_share * std::abs(before))
    return "";

  std::string text = fmt::format("{} {}", net < 0.0 ? "less" : "more", name);
  const double margin = at_the_edge * course.length();
  const double from = course.places[onset];
  const double until = course.places[end - 1];
  if (from > course.places.front() + 2.0 * margin && from > margin)
    text += " from " + course.text(from);
  if (until < course.places.back() - margin) text += " until " + course.text(until);
  if (before > 0.0) text += fmt::format(" ({:+.0f} %)", 100.0 * net / before);
  return text;
}

std::string level_text(const char* name, const char* unit, const Pair& pair, std::size_t end) {
  std::size_t place = 0;
  for (std::size_t i = 0; i < end; ++i)
    if (std::abs(pair.difference(i)) > std::abs(pair.difference(place))) place = i;

  const v1::PlantUnit plant = plant_unit(unit);
  return fmt::format("{} {:.0f} -> {:.0f} {} at {}", name, plant.factor() * pair.first[place],
                     plant.factor() * pair.other[place], plant.name(),
                     pair.course.text(pair.course.places[place]));
}

/// How much longer the second run stands on the block; empty without an axis of time.
std::string contact_text(const Pair& pair) {
  constexpr double touches = 0.05;  // of the scale
  constexpr double least_s = 2.0;
  if (pair.course.by_length) return "";

  const double threshold = touches * pair.scale();
  const auto duration = [&](const std::vector<double>& contact) {
    return pair.sum(0, pair.size(),
                    [&](std::size_t i) { return contact[i] > threshold ? 1.0 : 0.0; });
  };
  const double longer = duration(pair.other) - duration(pair.first);
  if (std::abs(longer) < std::max(least_s, least_share * pair.course.length())) return "";
  return fmt::format("contact with the block {:.0f} s {}", std::abs(longer),
                     longer > 0.0 ? "longer" : "shorter");
}

/// Empty where there is nothing to say.
std::string cause_text(const Figure& figure, const char* name, const char* unit, const Pair& pair,
                       std::size_t onset, std::size_t end) {
  if (figure.wording == Wording::contact)
    if (std::string text = contact_text(pair); !text.empty()) return text;
  if (figure.wording == Wording::level || figure.wording == Wording::shell)
    return level_text(name, unit, pair, end);
  return flow_text(name, pair, onset);
}

/// Where the curls come apart, as indices of the course.
struct Parting {
  std::size_t half;  ///< half of the difference has come about
  std::size_t end;   ///< behind the place where nine tenths have
};

std::optional<Cause> cause_by(const Figure& figure, const JudgedRun& first, const JudgedRun& other,
                              const Course& course, const Parting& parting) {
  constexpr double begins = 0.1;  // of the largest difference of the figure
  const bool slab = first.description.section().kind() == v1::Section::QUARTER_SLAB;
  const char* const name = slab ? figure.in_slab : figure.in_section;
  const char* const unit = slab ? figure.slab_unit : figure.section_unit;
  if (name == nullptr) return std::nullopt;

  const Pair pair{course, values_along(course, figure, first), values_along(course, figure, other),
                  comparable_from(course, first, other)};
  const double most = pair.largest_difference(parting.end);
  if (most <= 0.0) return std::nullopt;

  const double sum =
      pair.sum(0, parting.end, [&](std::size_t i) { return std::abs(pair.difference(i)); });
  const double share =
      sum / (pair.scale() * pair.sum(0, parting.end, [](std::size_t) { return 1.0; }));
  std::size_t onset = 0;
  while (std::abs(pair.difference(onset)) < begins * most) ++onset;
  if (share < least_share || onset > parting.half) return std::nullopt;

  std::string text = cause_text(figure, name, unit, pair, onset, parting.end);
  if (text.empty()) return std::nullopt;
  return Cause{name, unit, std::move(text), course.places[onset], share, pair.first, pair.other};
}

}  // namespace

std::vector<Cause> find_causes(const JudgedRun& first, const JudgedRun& other,
                               const CurlDifference& difference) {
  const Course& course = difference.course;
  if (difference.verdict() == Verdict::no_difference || course.places.size() < 2) return {};

  const std::string& monitor = difference.monitor;
  const Pair curl{course, curl_along(course, first, monitor), curl_along(course, other, monitor)};
  const Parting parting{first_reached(curl, 0.5), first_reached(curl, 0.9) + 1};
  std::vector<Cause> causes;
  for (const Figure& figure : figures)
    if (auto cause = cause_by(figure, first, other, course, parting))
      causes.push_back(std::move(*cause));

  std::ranges::stable_sort(causes, std::ranges::greater{}, &Cause::share);
  if (causes.size() > most_causes) causes.resize(most_causes);
  std::ranges::stable_sort(causes, {}, &Cause::onset);
  return causes;
}

std::string sentence(const CurlDifference& difference,
                     const std::optional<std::vector<Cause>>& causes) {
  constexpr double shown_finely_m = 1e-3;  // an error below it is given in hundredths of a mm
  const Verdict verdict = difference.verdict();
  const Course& course = difference.course;
  const std::optional<double>& error_m = difference.error_m;
  const int decimals = error_m && *error_m < shown_finely_m ? 2 : 1;
  std::string text =
      fmt::format("{} at {}: {:+.{}f}", difference.monitor, course.text(course.places.back()),
                  1e3 * difference.end_m, decimals);
  if (error_m) text += fmt::format(" ± {:.{}f}", 1e3 * *error_m, decimals);
  text += fmt::format(" mm, {}.", words(verdict));
  if (verdict == Verdict::within_its_error || !causes) return text;

  if (causes->empty()) return text + " No figure of the runs differs before the curl does.";
  std::string list = joined(*causes, ", ", &Cause::sentence);
  list[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(list[0])));
  return fmt::format("{} {}.", text, list);
}

}  // namespace dccast::judging
