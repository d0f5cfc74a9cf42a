#include "core/findings/of_case.hpp"
#include "core/findings/sentence.hpp"

namespace dccast::casting {

namespace {

/// Running water takes precedence over zones: a zone below the water line has no effect while it
/// runs.
bool under_water(const thermal::CoolingSpec& cooling, const thermal::SideZone& zone,
                 const Course& course) {
  return cooling.water.enabled && cooling.water.start <= course.begin &&
         zone.from >= cooling.water.from;
}

}  // namespace

std::optional<Finding> zone_never_meets(const Case& c, const Course& course) {
  std::vector<std::string> names;
  std::string first;
  for (std::size_t i = 0; i < c.cooling.zones.size(); ++i) {
    const thermal::SideZone& zone = c.cooling.zones[i];
    if (zone.from < course.depth && !under_water(c.cooling, zone, course)) continue;
    names.push_back("'" + zone.name + "'");
    if (first.empty()) first = "cooling.zone[" + std::to_string(i) + "].from";
  }
  if (names.empty() || !c.thermal.file.empty()) return std::nullopt;
  Finding finding;
  finding.code = "zone_never_meets";
  finding.severity = Severity::warning;
  finding.message = "The slab never reaches the cooling zone " + listed(names) +
                    sentence(
                        " (metal %.4g mm deep at the end): it has no effect, as if that part of "
                        "the mould did not exist.",
                        in_mm * course.depth);
  finding.key = first;
  return finding;
}

}  // namespace dccast::casting
