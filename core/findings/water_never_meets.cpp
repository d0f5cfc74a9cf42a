#include <algorithm>

#include "core/findings/of_case.hpp"
#include "core/findings/sentence.hpp"

namespace dccast::casting {

namespace {

struct Cause {
  std::string text;  ///< empty: the water meets the slab
  const char* key = "";
};

Cause cause_of(const Case& c, const Course& course) {
  const auto positive = [](double value) { return value > 0.0; };
  const thermal::Water& water = c.cooling.water;
  if (!water.enabled) return {"No water runs", "cooling.water.enabled"};
  if (water.start >= course.end)
    return {sentence("The water is turned on at %.6g s, after the end at %.6g s", water.start,
                     course.end),
            "cooling.water.start"};
  if (course.depth <= water.from)
    return {sentence("The water line lies %.4g mm below the metal level, and the metal is %.4g mm "
                     "deep at the end",
                     in_mm * water.from, in_mm * course.depth),
            "cooling.water.from"};
  const std::vector<double> flows = values_in(c.schedule.water_flow, course);
  const std::vector<double> factors = values_in(c.schedule.water_flow_factor, course);
  if (std::ranges::none_of(flows, positive) || std::ranges::none_of(factors, positive))
    return {"The water flow is zero throughout", "schedule.water_flow"};
  return {};
}

}  // namespace

std::optional<Finding> water_never_meets(const Case& c, const Course& course) {
  if (!c.thermal.file.empty()) return std::nullopt;
  const Cause cause = cause_of(c, course);
  if (cause.text.empty()) return std::nullopt;
  Finding finding;
  finding.code = "water_never_meets";
  finding.severity = Severity::warning;
  finding.message = cause.text +
                    ": below the mould the shell loses its heat to the air alone, and the metal "
                    "behind it melts it again.";
  finding.key = cause.key;
  return finding;
}

}  // namespace dccast::casting
