#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>

#include <fmt/core.h>

#include "client/model/comparison.hpp"

namespace dccast::client {
namespace {

constexpr double least_share = 0.03;  ///< of a figure's scale, see causes_of()
constexpr std::size_t most_causes = 3;

/// How a difference of a figure is put.
enum class Kind {
  flow,     ///< "less heat ... (-22 %)", summed over the places where it differs
  level,    ///< "shell ... 62 -> 71 mm", where it differs most
  shell,    ///< as a level, where the section is not solid through, as the butt is
  contact,  ///< "contact ... 8 s longer", otherwise as a flow
};

/// A figure of the step report. Of the figures per metre of face and of the whole quarter, the one
/// that a run does not have is zero.
struct Figure {
  Kind kind;
  const char* in_slab;     ///< its name in a quarter slab
  const char* in_section;  ///< in a section; null: it has none
  const char* unit;
  double factor;  ///< from SI to `unit`
  double (*value)(const v1::StepReport&);
};

using Step = v1::StepReport;

constexpr std::array figures{
    Figure{Kind::flow, "heat through the wide face", "heat through the side", "kW", 1e-3,
           [](const Step& s) { return s.side_heat_w() + s.side_heat_w_per_m(); }},
    Figure{Kind::flow, "heat through the narrow face", nullptr, "kW", 1e-3,
           [](const Step& s) { return s.narrow_heat_w(); }},
    Figure{Kind::flow, "heat into the block", "heat into the block", "kW", 1e-3,
           [](const Step& s) { return s.bottom_heat_w() + s.bottom_heat_w_per_m(); }},
    Figure{Kind::flow, "heat of the metal", "heat of the metal", "kW", 1e-3,
           [](const Step& s) {
             return s.metal_heat_w() + s.metal_heat_w_per_m() + s.level_heat_w() +
                    s.level_heat_w_per_m();
           }},
    Figure{Kind::contact, "contact with the block", "contact with the block", "dm2", 1e2,
           [](const Step& s) { return s.contact_area_m2() + s.contact_length_m(); }},
    Figure{Kind::shell, "shell at the water line", "shell at the water line", "mm", 1e3,
           [](const Step& s) { return s.shell_at_water_line_m(); }},
    Figure{Kind::level, "shell over the block", "shell over the block", "mm", 1e3,
           [](const Step& s) { return s.bottom_shell_m(); }},
    Figure{Kind::level, "depth of the sump", "depth of the sump", "mm", 1e3,
           [](const Step& s) { return s.sump_depth_m(); }},
    Figure{Kind::level, "wetted share of the wide face", "wetted share of the side", "%", 1e2,
           [](const Step& s) { return s.wetted_share(); }},
    Figure{Kind::level, "block surface", "block surface", "degC", 1.0,
           [](const Step& s) { return s.block_temperature_c(); }},
};

/// Both runs along the course, and the weight of each place.
struct Pair {
  const Course& course;
  std::vector<double> first, other;

  std::size_t size() const { return first.size(); }
  double apart(std::size_t i) const {
    const double d = other[i] - first[i];
    return std::isfinite(d) ? d : 0.0;
  }
  /// Half of the course on either side of a place [s] or [m].
  double weight(std::size_t i) const {
    const auto& at = course.at;
    return 0.5 * (at[std::min(i + 1, at.size() - 1)] - at[i == 0 ? 0 : i - 1]);
  }
  /// Sum over places with their weights. @param term  (place)
  template <class Term>
  double sum(std::size_t begin, std::size_t end, Term term) const {
    double total = 0.0;
    for (std::size_t i = begin; i < end; ++i) total += weight(i) * term(i);
    return total;
  }
  double largest(std::size_t end) const {
    double most = 0.0;
    for (std::size_t i = 0; i < end; ++i) most = std::max(most, std::abs(apart(i)));
    return most;
  }
  /// Range of the two, with zero unless both are far from it.
  double scale() const {
    double low = 0.0, high = 0.0;
    for (const auto* values : {&first, &other})
      for (const double v : *values)
        if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
    return high - low;
  }
};

/// From the middle of a section to its side [m], where that is nearest.
double half_thickness_m(const v1::Section& section) {
  double half = section.half_width_m();
  for (const double value : section.half_thickness_m().value()) half = std::min(half, value);
  return half > 0.0 ? half : std::numeric_limits<double>::infinity();
}

Pair pair_of(const Figure& figure, const Answer& first, const Answer& other, const Course& course) {
  const auto values = [&](const Answer& answer) {
    constexpr double solid_through = 0.98;
    const double most = figure.kind == Kind::shell
                            ? solid_through * half_thickness_m(answer.description.section())
                            : std::numeric_limits<double>::infinity();
    std::vector<double> value;
    for (const Step& step : answer.history.reports)
      value.push_back(figure.value(step) < most ? figure.factor * figure.value(step)
                                                : std::numeric_limits<double>::quiet_NaN());
    return along(course, answer.history, value);
  };
  return {course, values(first), values(other)};
}

/// First place from which on the difference has reached a share of its value at the end.
std::size_t reached(const Pair& curl, double share) {
  const double end = curl.apart(curl.size() - 1);
  std::size_t place = curl.size() - 1;
  while (place > 0 && curl.apart(place - 1) * end >= share * end * end) --place;
  return place;
}

std::string flow_text(const char* name, const Pair& pair, const Course& course, std::size_t onset) {
  constexpr double acts = 0.25;         // of the largest difference
  constexpr double one_sided = 0.7;     // else the difference changes its sign
  constexpr double at_the_edge = 0.05;  // of the course
  std::size_t end = pair.size();
  const double most = pair.largest(end);
  while (end > onset + 1 && std::abs(pair.apart(end - 1)) < acts * most) --end;
  const double net = pair.sum(onset, end, [&](std::size_t i) { return pair.apart(i); });
  const double gross = pair.sum(onset, end, [&](std::size_t i) { return std::abs(pair.apart(i)); });
  const double before = pair.sum(onset, end, [&](std::size_t i) {
    return std::isfinite(pair.first[i]) ? pair.first[i] : 0.0;
  });
  if (std::abs(net) < one_sided * gross || std::abs(net) < least_share * std::abs(before))
    return "";
  std::string text = std::string(net < 0.0 ? "less " : "more ") + name;
  const double margin = at_the_edge * course.length();
  if (course.at[onset] > course.at.front() + 2.0 * margin && course.at[onset] > margin)
    text += " from " + course.text(course.at[onset]);
  if (course.at[end - 1] < course.at.back() - margin)
    text += " until " + course.text(course.at[end - 1]);
  return before > 0.0 ? text + fmt::format(" ({:+.0f} %)", 100.0 * net / before) : text;
}

std::string level_text(const Figure& figure, const char* name, const Pair& pair,
                       const Course& course, std::size_t end) {
  std::size_t most = 0;
  for (std::size_t i = 0; i < end; ++i)
    if (std::abs(pair.apart(i)) > std::abs(pair.apart(most))) most = i;
  return fmt::format("{} {:.0f} -> {:.0f} {} at {}", name, pair.first[most], pair.other[most],
                     figure.unit, course.text(course.at[most]));
}

/// How much longer the second run stands on the block; empty without an axis of time.
std::string contact_text(const Pair& pair, const Course& course) {
  constexpr double touches = 0.05, least_s = 2.0;  // of the scale; [s]
  if (course.by_length) return "";
  const double threshold = touches * pair.scale();
  const auto lasts = [&](const std::vector<double>& contact) {
    return pair.sum(0, pair.size(),
                    [&](std::size_t i) { return contact[i] > threshold ? 1.0 : 0.0; });
  };
  const double longer = lasts(pair.other) - lasts(pair.first);
  if (std::abs(longer) < std::max(least_s, least_share * course.length())) return "";
  return fmt::format("contact with the block {:.0f} s {}", std::abs(longer),
                     longer > 0.0 ? "longer" : "shorter");
}

}  // namespace

std::vector<Cause> causes_of(const Answer& first, const Answer& other,
                             const CurlDifference& difference) {
  constexpr double begins = 0.1;  // of the largest difference of the figure
  const Course& course = difference.course;
  if (difference.none() || course.at.size() < 2) return {};
  const auto curl_of = [&](const Answer& answer) {
    const auto series =
        std::ranges::find(answer.history.monitors, difference.monitor, &CurlHistory::Series::name);
    return along(course, answer.history, series->curl_m);
  };
  const Pair curl{course, curl_of(first), curl_of(other)};
  const std::size_t half = reached(curl, 0.5), end = reached(curl, 0.9) + 1;
  const bool slab = first.description.section().kind() == v1::Section::QUARTER_SLAB;
  std::vector<Cause> causes;
  for (const Figure& figure : figures) {
    const char* const name = slab ? figure.in_slab : figure.in_section;
    if (name == nullptr) continue;
    const Pair pair = pair_of(figure, first, other, course);
    const double most = pair.largest(end), scale = pair.scale();
    if (most <= 0.0) continue;
    const double share = pair.sum(0, end, [&](std::size_t i) { return std::abs(pair.apart(i)); }) /
                         (scale * pair.sum(0, end, [](std::size_t) { return 1.0; }));
    std::size_t onset = 0;
    while (std::abs(pair.apart(onset)) < begins * most) ++onset;
    if (share < least_share || onset > half) continue;
    std::string text = figure.kind == Kind::contact ? contact_text(pair, course) : "";
    if (text.empty())
      text = figure.kind == Kind::level || figure.kind == Kind::shell
                 ? level_text(figure, name, pair, course, end)
                 : flow_text(name, pair, course, onset);
    if (text.empty()) continue;
    causes.push_back({name, figure.unit, text, course.at[onset], share, pair.first, pair.other});
  }
  std::ranges::stable_sort(causes, std::ranges::greater{}, &Cause::share);
  if (causes.size() > most_causes) causes.resize(most_causes);
  std::ranges::stable_sort(causes, {}, &Cause::onset);
  return causes;
}

std::string sentence(const CurlDifference& d, const std::vector<Cause>& causes, bool explained) {
  if (d.none()) return d.monitor + ": no difference.";
  const int decimals = d.error_m && *d.error_m < 1e-3 ? 2 : 1;
  std::string text = d.monitor + ": " + fmt::format("{:+.{}f}", 1e3 * d.end_m, decimals);
  if (d.error_m) text += fmt::format(" ± {:.{}f}", 1e3 * *d.error_m, decimals);
  text += std::string(" mm, ") + verdict(d) + ".";
  if (d.error_m && !d.real()) return text;
  std::string list;
  for (const Cause& cause : causes) list += (list.empty() ? "" : ", ") + cause.sentence;
  if (list.empty())
    return explained ? text + " No figure of the runs differs before the curl does." : text;
  list[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(list[0])));
  return text + " " + list + ".";
}

}  // namespace dccast::client
