#include "core/casting/check/checks.hpp"

#include <string>

#include "core/fem/point_location.hpp"

namespace dccast::casting {

namespace {

/// Of coordinates, as the location of a point in the mesh forgives it [m].
constexpr double round_off = 1e-9;

void beside_or_above(CaseFindings& found, const std::string& field, const Monitor& m) {
  if (found.sound({field + ".x", "section.half_width"}) &&
      m.x > found.casting.section.half_width + round_off) {
    found.fault(field + ".x", with_unit(m.x, "m"), "lies outside the slab",
                "0 m to section.half_width = " + with_unit(found.casting.section.half_width, "m"),
                "move the monitor");
  }
  if (found.sound({field + ".y"}) && found.sound(course_keys) &&
      m.y > *found.final_level + round_off) {
    found.fault(field + ".y", with_unit(m.y, "m"), "lies outside the slab",
                "0 m to the final metal level, " + with_unit(*found.final_level, "m"),
                "move the monitor");
  }
}

void outside_the_mesh(CaseFindings& found, const std::string& field, const Monitor& m) {
  if (!found.sound({field + ".x", field + ".y", "mesh.file", "mesh.element"})) return;
  if (fem::locate(*found.imported, point_of<2>(m))) return;
  found.fault(field + ".y", with_unit(m.y, "m"), "lies outside the slab",
              "a point of the imported mesh", "move the monitor");
}

void check_monitor(CaseFindings& found, std::size_t index) {
  const Monitor& m = found.casting.monitors[index];
  const std::string field = "monitor[" + std::to_string(index) + "]";
  for (std::size_t j = 0; j < index; ++j) {
    if (found.casting.monitors[j].name == m.name) {
      found.fault(field + ".name", m.name, "is the name of an earlier monitor", "a name of its own",
                  "rename it");
    }
  }
  found.casting.section.file.empty() ? beside_or_above(found, field, m)
                                     : outside_the_mesh(found, field, m);
}

}  // namespace

void check_monitors(CaseFindings& found) {
  for (std::size_t i = 0; i < found.casting.monitors.size(); ++i) check_monitor(found, i);
}

}  // namespace dccast::casting
