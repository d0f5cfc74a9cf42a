#include "core/case/check/checks.hpp"

#include <string>

namespace dccast::casting {

void check_zones(CaseFindings& found) {
  for (std::size_t i = 0; i < found.casting.cooling.zones.size(); ++i) {
    const thermal::SideZone& zone = found.casting.cooling.zones[i];
    const std::string field = "cooling.zone[" + std::to_string(i) + "]";
    if (!found.sound({field + ".from", field + ".to"})) continue;
    if (zone.to <= zone.from) {
      found.fault(
          field + ".to", with_unit(zone.to, "m"), "does not lie below the zone's upper edge",
          "more than " + field + ".from = " + with_unit(zone.from, "m"), "exchange from and to");
    }
    for (std::size_t j = 0; j < i; ++j) {
      const thermal::SideZone& other = found.casting.cooling.zones[j];
      if (!found.sound({"cooling.zone[" + std::to_string(j) + "]"})) continue;
      if (zone.face && other.face && *zone.face != *other.face) continue;
      if (zone.from < other.to - 1e-12 && other.from < zone.to - 1e-12) {
        found.fault(field + ".from", with_unit(zone.from, "m"),
                    "overlaps the zone '" + other.name + "'",
                    "bands that do not overlap; that zone ends at " + with_unit(other.to, "m"),
                    "move the edge");
      }
    }
  }
}

}  // namespace dccast::casting
