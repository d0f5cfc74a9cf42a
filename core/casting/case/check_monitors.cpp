#include <algorithm>
#include <string>

#include "core/casting/case/checks.hpp"
#include "core/fem/point_location.hpp"
#include "core/mesh/base.hpp"
#include "core/mesh/plan_file.hpp"

namespace dccast::casting {

namespace {

void lies_outside(CaseFindings& found, const std::string& field, double coordinate,
                  const std::string& permitted, const std::string& remedy = "move the monitor") {
  found.fault(field, with_unit(coordinate, "m"), "lies outside the slab", permitted, remedy);
}

void above(CaseFindings& found, const std::string& field, double height) {
  if (!found.sound({field}) || !found.sound(course_keys)) return;
  if (height > *found.final_level + length_round_off)
    lies_outside(found, field, height,
                 "0 m to the final metal level, " + with_unit(*found.final_level, "m"));
}

/// Depth of the bowl below the block's lip at the place of a monitor [m]. @pre there is a bowl
double depth_of_block(CaseFindings& found, const Monitor& m) {
  const mesh::SectionSpec& section = found.casting.section;
  const double inward = found.solid()
                            ? mesh::distance_from_edge(section, found.built_in_plan(), m.x, m.y)
                            : mesh::distance_from_edge(section, m.x);
  return section.bowl->depth_at(inward);
}

/// Whether a point lies in the block. @param depth  of the block there [m]
void below(CaseFindings& found, const std::string& field, double height, double depth) {
  if (height < -depth - length_round_off)
    lies_outside(found, field, height, "at least " + with_unit(-depth, "m") + ", the block there");
}

/// The same under the built-in mesh.
void below_built_in(CaseFindings& found, const std::string& field, const Monitor& m,
                    double height) {
  const bool is_flat = !found.casting.section.bowl;
  if (!is_flat && !found.sound(plan_keys)) return;
  below(found, field, height, is_flat ? 0.0 : depth_of_block(found, m));
}

/// Whether a point of a quarter slab lies beyond the wide face.
void behind(CaseFindings& found, const std::string& field, const Monitor& m) {
  if (!found.sound({field + ".x", field + ".y", "section.half_thickness"})) return;
  const mesh::SectionSpec& section = found.casting.section;
  double opening = section.half_thickness(m.x);
  if (section.corner_radius > 0.0 && found.sound(plan_keys))
    opening = std::min(opening, mesh::reach_of(found.built_in_plan(), m.x));
  if (m.y > opening + length_round_off)
    lies_outside(found, field + ".y", m.y,
                 "0 m to half the opening of the mould there, " + with_unit(opening, "m"),
                 "move the monitor; its height is z");
}

void beside_or_above(CaseFindings& found, const std::string& field, const Monitor& m) {
  const double half_width = found.casting.section.half_width;
  if (found.sound({field + ".x", "section.half_width"}) && m.x > half_width + length_round_off)
    lies_outside(found, field + ".x", m.x,
                 "0 m to section.half_width = " + with_unit(half_width, "m"));
  if (!found.solid()) {
    above(found, field + ".y", m.y);
    return below_built_in(found, field + ".y", m, m.y);
  }
  behind(found, field, m);
  above(found, field + ".z", m.z.value_or(0.0));
  below_built_in(found, field + ".z", m, m.z.value_or(0.0));
}

/// Whether a point lies beside the plan of a file, above the metal or in the block.
void outside_the_plan(CaseFindings& found, const std::string& field, const Monitor& m) {
  if (!found.sound({field + ".x", field + ".y", "mesh.file", "mesh.element"}) || !found.plan)
    return;
  const mesh::Mesh2D cells = mesh::flat_mesh(*found.plan);
  const auto place = fem::locate(cells, {m.x, m.y});
  if (!place)
    return lies_outside(found, field + ".y", m.y, "a point of the plan in mesh.file",
                        "move the monitor; its height is z");

  const double height = m.z.value_or(0.0);
  const auto& depth = found.plan->depth;
  above(found, field + ".z", height);
  below(found, field + ".z", height, depth.empty() ? 0.0 : fem::interpolate(cells, *place, depth));
}

/// A quarter slab has three coordinates, a section two.
void check_coordinates(CaseFindings& found, const std::string& field, const Monitor& m) {
  if (!found.sound({"section.kind", field + ".z"})) return;
  if (found.solid() && !m.z)
    found.fault(field + ".z", "", "is missing: x and y are distances from the symmetry planes",
                "a height above the bottom block with section.kind = \"quarter_slab\"",
                "write z = \"0 m\" for a point of the bottom");
  if (!found.solid() && m.z)
    found.fault(field + ".z", with_unit(*m.z, "m"), "applies to a quarter slab only",
                "x and y, the height, in a section", "leave z out");
}

template <int Dim>
void outside_the_mesh(CaseFindings& found, const std::string& field, const Monitor& m) {
  if (!found.sound({field + ".x", field + ".y", "mesh.file", "mesh.element"})) return;
  const auto& mesh = std::get<std::optional<mesh::Mesh<Dim>>>(found.imported);
  if (mesh && !fem::locate(*mesh, point_of<Dim>(m)))
    lies_outside(found, field + ".y", m.y, "a point of the imported mesh");
}

/// The points of a mean must be there, each once.
void check_mean(CaseFindings& found, const std::string& field,
                const std::vector<MonitorShare>& of) {
  const auto& monitors = found.casting.monitors;
  for (std::size_t i = 0; i < of.size(); ++i) {
    const std::string& name = of[i].monitor;
    const std::string key = field + ".of[" + std::to_string(i) + "].monitor";
    const auto member = std::ranges::find(monitors, name, &Monitor::name);
    if (member == monitors.end() || !member->of.empty())
      found.fault(key, name, "is no monitor with a place", "the name of a [[monitor]] with x and y",
                  "name a point");
    else if (std::ranges::find(of.begin(), of.begin() + long(i), name, &MonitorShare::monitor) !=
             of.begin() + long(i))
      found.fault(key, name, "is in this mean already", "each point once",
                  "give the point one weight");
  }
}

void check_monitor(CaseFindings& found, std::size_t index) {
  const Monitor& m = found.casting.monitors[index];
  const std::string field = "monitor[" + std::to_string(index) + "]";
  for (std::size_t j = 0; j < index; ++j)
    if (found.casting.monitors[j].name == m.name)
      found.fault(field + ".name", m.name, "is the name of an earlier monitor", "a name of its own",
                  "rename it");
  if (!m.of.empty()) return check_mean(found, field, m.of);
  check_coordinates(found, field, m);
  if (mesh::has_plan_file(found.casting.section)) return outside_the_plan(found, field, m);
  if (!mesh::has_mesh_file(found.casting.section)) return beside_or_above(found, field, m);
  found.solid() ? outside_the_mesh<3>(found, field, m) : outside_the_mesh<2>(found, field, m);
}

}  // namespace

void check_monitors(CaseFindings& found) {
  const auto& monitors = found.casting.monitors;
  for (std::size_t i = 0; i < monitors.size(); ++i) check_monitor(found, i);

  const std::string& judged = found.casting.output.curl;
  if (!judged.empty() && std::ranges::find(monitors, judged, &Monitor::name) == monitors.end())
    found.fault("output.curl", judged, "is no monitor of the case", "the name of a [[monitor]]",
                "name one, or leave the key out: the largest curl is judged");
}

void check_plausibility(CaseFindings& found) {
  const auto& least = found.casting.plausibility.least_curl;
  const auto& greatest = found.casting.plausibility.greatest_curl;
  if (!found.sound({"plausibility.least_curl", "plausibility.greatest_curl"})) return;
  if (!least || !greatest || *least < *greatest) return;
  found.fault("plausibility.greatest_curl", with_unit(*greatest, "m"),
              "does not lie above the lower edge of the band",
              "more than plausibility.least_curl = " + with_unit(*least, "m"),
              "exchange the two, or leave one out");
}

void advise(CaseFindings& found) {
  const Case& c = found.casting;
  if (c.monitors.empty())
    found.warning("monitor", "", "there is no monitor: no displacement will be reported", "",
                  "add a [[monitor]] table");
  if (c.mechanics.enabled && found.sound({"mechanics.start", "time.end"}) &&
      c.mechanics.start > c.time.end)
    found.warning("mechanics.start", with_unit(c.mechanics.start, "s"),
                  "lies after the end: the mechanics never starts");
}

}  // namespace dccast::casting
