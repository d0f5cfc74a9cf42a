#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <set>
#include <string_view>

#include "core/casting/case.hpp"
#include "core/casting/casting_schedule.hpp"
#include "core/casting/monitors.hpp"
#include "core/mesh/gmsh_reader.hpp"
#include "core/mesh/slab_mesh.hpp"
#include "core/results/temperature_file.hpp"

namespace dccast::casting {

namespace {

std::string with_unit(double value, const char* unit) {
  char text[48];
  std::snprintf(text, sizeof text, "%.6g %s", value, unit);
  return text;
}

/// Of coordinates, as the location of a point in the mesh forgives it [m].
constexpr double round_off = 1e-9;

using Keys = std::vector<std::string>;

/// What the course of the casting in time follows from.
const Keys course_keys = {"time.end",
                          "time.step",
                          "schedule.hold",
                          "schedule.casting_speed",
                          "cooling.water.start",
                          "mechanics.start",
                          "section.initial_depth",
                          "mesh.growth",
                          "limits.maximum_steps"};
/// What the number of cells of the built-in mesh follows from, besides the course.
const Keys grid_keys = {"mesh.columns",    "mesh.rows",    "mesh.growth_cell",
                        "mesh.refinement", "mesh.element", "limits.maximum_nodes"};
/// What the places of its nodes follow from, besides their number.
const Keys place_keys = {"section.half_width", "section.initial_depth", "mesh.side_cell",
                         "mesh.bottom_cell"};

/// Whether a fault at `path` leaves nothing certain about `key`: it is the key itself, a part of it
/// ("schedule.casting_speed[1]"), or the table it is in; without its card nothing of an alloy is.
bool covers(std::string_view path, std::string_view key) {
  const auto within = [](std::string_view part, std::string_view whole) {
    return part.starts_with(whole) &&
           (part.size() == whole.size() || part[whole.size()] == '.' || part[whole.size()] == '[');
  };
  return within(path, key) || within(key, path) ||
         (path == "alloy.card" && key.starts_with("alloy."));
}

/// Checks one case; each member adds its faults. A check that reasons from a key which is at fault
/// itself is left out, and the answer says so: `sound` decides.
class CaseCheck {
public:
  CaseCheck(const Case& c, const std::vector<std::string>& faulty_keys)
      : case_(c), faulty_keys_(faulty_keys) {}

  CheckedCase all() {
    alloy();
    zones();
    curves();
    section();
    time();
    mechanics();
    course();
    if (case_.section.file.empty()) built_in_size();
    else imported_mesh();
    prescribed_temperature();
    for (std::size_t i = 0; i < case_.monitors.size(); ++i) monitor(i);
    advice();
    for (const std::string& key : waited_for_) {
      result_.warnings.add(key, "", "further checks wait until this is mended");
    }
    return std::move(result_);
  }

private:
  template <class... Rest>
  void fault(Rest&&... rest) { result_.faults.add(std::forward<Rest>(rest)...); }

  /// The fault that leaves nothing certain about a key; empty when there is none.
  std::string fault_of(std::string_view key) const {
    for (const std::string& path : faulty_keys_) {
      if (covers(path, key)) return path;
    }
    for (const Fault& found : result_.faults.list()) {
      if (covers(found.field, key)) return found.field;
    }
    return {};
  }

  /// Whether what follows from these keys can be judged; if not, the answer will say what for.
  bool sound(const Keys& keys) {
    bool all = true;
    for (const std::string& key : keys) {
      const std::string path = fault_of(key);
      if (path.empty()) continue;
      waited_for_.insert(path);
      all = false;
    }
    return all;
  }

  void alloy() {
    const material::AlloyCard& a = case_.alloy;
    if (!sound({"alloy.solidus", "alloy.liquidus"})) return;
    if (a.solidus > a.liquidus) {
      fault("alloy.solidus", with_unit(a.solidus, "degC"), "lies above the liquidus",
            "at most alloy.liquidus = " + with_unit(a.liquidus, "degC"),
            "exchange the two, or make them equal for a pure metal");
    }
    if (sound({"alloy.solidus", "alloy.coherency"}) &&
        (a.coherency > a.liquidus || a.coherency < a.solidus - 100.0)) {
      fault("alloy.coherency", with_unit(a.coherency, "degC"),
            "is not a temperature of the mush",
            "up to alloy.liquidus = " + with_unit(a.liquidus, "degC") +
                ", not more than 100 K below alloy.solidus = " + with_unit(a.solidus, "degC"),
            "leave it out to take the liquidus");
    }
    if (!a.liquid_fraction.empty() && sound({"alloy.solidus", "alloy.liquid_fraction"})) {
      liquid_fraction();
    }
  }

  /// Without both ends in the table some of the latent heat would never be set free.
  void liquid_fraction() {
    const material::AlloyCard& a = case_.alloy;
    const Curve& f = a.liquid_fraction;
    const bool spans = !f.constant() && f.at().front() == a.solidus && f.value().front() == 0.0 &&
                       f.at().back() == a.liquidus && f.value().back() == 1.0;
    if (!spans || !std::is_sorted(f.value().begin(), f.value().end())) {
      fault("alloy.liquid_fraction", "table", "does not rise from 0 at the solidus to 1 at the liquidus",
            "first point [" + with_unit(a.solidus, "degC") + ", 0], last point [" +
                with_unit(a.liquidus, "degC") + ", 1], never falling between them",
            "complete the table, or leave it out for a linear liquid fraction");
    }
  }

  void increasing(const char* field, const Curve& curve, const char* unit) {
    if (!fault_of(field).empty()) return;  // said already
    for (std::size_t i = 1; i < curve.at().size(); ++i) {
      if (curve.at()[i] > curve.at()[i - 1]) continue;
      fault(field, with_unit(curve.at()[i], unit), "does not lie above the point before it",
            "strictly increasing first values", "sort the table and remove repeated points");
      return;
    }
  }

  void curves() {
    increasing("schedule.casting_speed", case_.schedule.casting_speed, "");
    increasing("schedule.casting_temperature", case_.schedule.casting_temperature, "");
    increasing("schedule.water_flow", case_.schedule.water_flow, "");
    increasing("time.step", case_.time.step, "s");
    increasing("alloy.density", case_.alloy.density, "degC");
    increasing("alloy.specific_heat", case_.alloy.specific_heat, "degC");
    increasing("alloy.conductivity", case_.alloy.conductivity, "degC");
    increasing("alloy.liquid_fraction", case_.alloy.liquid_fraction, "degC");
    increasing("alloy.young_modulus", case_.alloy.young_modulus, "degC");
    increasing("alloy.poisson_ratio", case_.alloy.poisson_ratio, "degC");
    increasing("cooling.bottom_block.contact_coefficient",
               case_.cooling.bottom_block.contact_coefficient, "s");
    increasing("cooling.bottom_block.gap_coefficient", case_.cooling.bottom_block.gap_coefficient,
               "m");
  }

  void zones() {
    for (std::size_t i = 0; i < case_.cooling.zones.size(); ++i) {
      const thermal::SideZone& zone = case_.cooling.zones[i];
      const std::string field = "cooling.zone[" + std::to_string(i) + "]";
      if (!sound({field + ".from", field + ".to"})) continue;
      if (zone.to <= zone.from) {
        fault(field + ".to", with_unit(zone.to, "m"), "does not lie below the zone's upper edge",
              "more than " + field + ".from = " + with_unit(zone.from, "m"), "exchange from and to");
      }
      for (std::size_t j = 0; j < i; ++j) {
        const thermal::SideZone& other = case_.cooling.zones[j];
        if (!sound({"cooling.zone[" + std::to_string(j) + "]"})) continue;
        if (zone.from < other.to - 1e-12 && other.from < zone.to - 1e-12) {
          fault(field + ".from", with_unit(zone.from, "m"),
                "overlaps the zone '" + other.name + "'",
                "bands that do not overlap; that zone ends at " + with_unit(other.to, "m"),
                "move the edge");
        }
      }
    }
  }

  void section() {
    const mesh::SectionSpec& s = case_.section;
    const bool growth_known = sound({"mesh.growth"});
    if (!s.file.empty() && s.growth && growth_known) {
      fault("mesh.growth", "true", "an imported mesh cannot grow", "false with mesh.file",
            "write growth = false, or leave mesh.file out");
    }
    if (case_.cooling.top == thermal::Top::insulated && s.growth && growth_known) {
      fault("cooling.top", "insulated", "metal is poured in at the top of a slab that grows",
            "pouring, or mesh.growth = false", "write top = \"pouring\"");
    }
    if (!case_.thermal.file.empty() && s.growth && growth_known) {
      fault("thermal.file", case_.thermal.file.filename().string(),
            "has one temperature a node, and a slab that grows has ever more nodes",
            "mesh.growth = false with thermal.file", "write growth = false in [mesh]");
    }
    const double cell = s.growth_cell.value_or(s.initial_depth / s.rows);
    if (s.growth && sound({"mesh.growth_cell", "mesh.rows", "section.initial_depth"}) &&
        cell > s.initial_depth) {
      fault("mesh.growth_cell", with_unit(cell, "m"), "is higher than the metal at the start",
            "at most section.initial_depth = " + with_unit(s.initial_depth, "m"),
            "choose smaller growth cells");
    }
    if (s.file.empty() && sound({"mesh.side_cell", "section.half_width"}) &&
        s.side_cell > s.half_width) {
      fault("mesh.side_cell", with_unit(s.side_cell, "m"), "is wider than the section",
            "at most section.half_width = " + with_unit(s.half_width, "m"), "choose a smaller cell");
    }
    if (s.file.empty() && sound({"mesh.bottom_cell", "section.initial_depth"}) &&
        s.bottom_cell > s.initial_depth) {
      fault("mesh.bottom_cell", with_unit(s.bottom_cell, "m"), "is higher than the metal",
            "at most section.initial_depth = " + with_unit(s.initial_depth, "m"),
            "choose a smaller cell");
    }
    if (sound({"section.kind", "mesh.element", "mechanics.enabled"}) && axisymmetric() &&
        case_.mechanics.enabled && s.element == mesh::ElementKind::p1) {
      // A creeping tube of triangles is 26 % off where one of quadrilaterals is 1.5 %
      // (`dccast-verify run tube-creep`). Nor does the liquid's pressure, one value a triangle,
      // carry its weight near the axis.
      fault("mesh.element", "p1", "triangles lock in an axisymmetric section",
            "q1_bending or q1 with mechanics and section.kind = \"axisymmetric\"",
            "write element = \"q1_bending\"");
    }
  }

  bool axisymmetric() const { return case_.section.kind == mesh::SectionKind::axisymmetric; }

  void time() {
    if (sound({"time.end", "schedule.hold"}) && case_.time.end <= -case_.schedule.hold) {
      fault("time.end", with_unit(case_.time.end, "s"), "does not lie after the beginning",
            "more than " + with_unit(-case_.schedule.hold, "s") + ", minus schedule.hold",
            "move the end");
    }
    if (!sound({"time.step", "time.minimum_step"})) return;
    const auto& steps = case_.time.step.value();
    const double shortest = *std::min_element(steps.begin(), steps.end());
    if (case_.time.minimum_step > shortest) {
      fault("time.minimum_step", with_unit(case_.time.minimum_step, "s"),
            "is longer than the shortest step", "at most " + with_unit(shortest, "s"),
            "choose a smaller minimum, such as a hundredth of the step");
    }
  }

  void mechanics() {
    const auto& p = case_.mechanics.options.parameters;
    const double product = p.lambda_p.value_or(0.5 / p.gamma_p) * p.gamma_p;
    if (case_.mechanics.options.algorithm == mechanics::Algorithm::sbm &&
        sound({"mechanics.parameters.gamma_p", "mechanics.parameters.lambda_p"}) &&
        product >= 1.0) {
      fault("mechanics.parameters.lambda_p", p.lambda_p.value_or(0.0),
            "times gamma_p is not below 1 (Lemma 3)", "less than 1 / gamma_p",
            "leave it out to take 1 / (2 gamma_p)");
    }
  }

  /// Steps, and how high the metal ends.
  void course() {
    if (!sound(course_keys)) return;
    const CastingSchedule schedule(case_);
    double time = schedule.begin(), length = 0.0;
    std::int64_t steps = 0;
    while (time < schedule.end() - 1e-9 && steps <= case_.limits.maximum_steps) {
      const double dt = schedule.step_at(time);
      length = schedule.cast_length(length, time, dt);
      time += dt;
      ++steps;
    }
    if (steps > case_.limits.maximum_steps) {
      fault("time.step", with_unit(case_.time.step(time), "s"), "leads to too many time steps",
            "at most limits.maximum_steps = " + std::to_string(case_.limits.maximum_steps),
            "lengthen the steps or shorten the simulation");
      return;
    }
    final_level_ = case_.section.initial_depth + (case_.section.growth ? length : 0.0);
    result_.estimate.steps = steps;
  }

  void built_in_size() {
    const mesh::SectionSpec& s = case_.section;
    if (!sound(grid_keys) || !sound(course_keys)) return;
    const double cell = s.growth_cell.value_or(s.initial_depth / s.rows) / s.refinement;
    // Before any mesh is built: a growth cell of micrometres must not be tried.
    const double rough = (s.rows * s.refinement + (*final_level_ - s.initial_depth) / cell) *
                         (s.columns * s.refinement + 1.0);
    if (rough > 2.0 * static_cast<double>(case_.limits.maximum_nodes)) return too_many_nodes(rough);
    const std::int64_t rows = mesh::rows_at(s, *final_level_);
    const std::int64_t columns = std::int64_t(s.columns) * s.refinement;
    result_.estimate.nodes = (rows + 1) * (columns + 1);
    result_.estimate.elements = rows * columns * (s.element == mesh::ElementKind::p1 ? 2 : 1);
    if (result_.estimate.nodes > case_.limits.maximum_nodes) {
      too_many_nodes(static_cast<double>(result_.estimate.nodes));
    }
    effort();
  }

  void too_many_nodes(double nodes) {
    fault("mesh.columns", std::to_string(case_.section.columns),
          "leads to " + with_unit(nodes, "nodes at the end"),
          "at most limits.maximum_nodes = " + std::to_string(case_.limits.maximum_nodes),
          "use fewer or larger cells, or raise the limit");
  }

  /// Measured on one core: 2 us a node, Newton iteration and pass, and a factorisation that grows
  /// with the power 1.24 of the size; 4.5 iterations a step.
  void effort() {
    Estimate& e = result_.estimate;
    const double nodes = static_cast<double>(e.nodes);
    e.solver_seconds = static_cast<double>(e.steps) * (6e-6 * nodes + 2e-7 * std::pow(nodes, 1.24));
    e.memory_bytes = 3e7 + 1.2e4 * nodes;
  }

  void imported_mesh() {
    if (!sound({"mesh.file", "mesh.element"})) return;
    imported_ = mesh::read_gmsh<2>(case_.section.file, case_.section.element, result_.faults);
    if (!imported_) return;
    result_.estimate.nodes = imported_->nodes();
    result_.estimate.elements = imported_->elements();
    if (sound({"section.kind"}) && axisymmetric()) beyond_the_axis(*imported_);
    if (sound({"limits.maximum_nodes"}) && imported_->nodes() > case_.limits.maximum_nodes) {
      too_many_nodes(imported_->nodes());
    }
    effort();
  }

  void prescribed_temperature() {
    if (case_.thermal.file.empty() || !sound({"thermal.file"})) return;
    const auto nodes = nodes_at_the_start();
    if (!nodes) return;
    const auto history = results::read_temperature_file(case_.thermal.file, *nodes, result_.faults);
    if (history && sound({"time.end", "schedule.hold"})) temperature_range(*history);
  }

  /// Nothing when they wait for a fault.
  std::optional<std::size_t> nodes_at_the_start() {
    if (imported_) return std::size_t(imported_->nodes());
    if (!sound({"mesh.file"}) || !sound(grid_keys) || !sound(place_keys)) return std::nullopt;
    return std::size_t(mesh::SlabMesh(case_.section).mesh().nodes());
  }

  void beyond_the_axis(const mesh::Mesh2D& mesh) {
    double nearest = 0.0;
    for (int n = 0; n < mesh.nodes(); ++n) nearest = std::min(nearest, mesh.point(n)[0]);
    if (nearest >= 0.0) return;
    fault("mesh.file", case_.section.file.filename().string(),
          "has a node at " + with_unit(nearest, "m") + ", beyond the axis of the billet",
          "distances from the axis of 0 m and more with section.kind = \"axisymmetric\"",
          "mesh the right half of the section");
  }

  void temperature_range(const results::TemperatureHistory& history) {
    if (history.begin() <= -case_.schedule.hold + 1e-9 && history.end() >= case_.time.end - 1e-9) {
      return;
    }
    result_.warnings.add("thermal.file", case_.thermal.file.filename().string(),
                         "does not cover the simulated time; its first and last temperatures are "
                         "held outside",
                         "from " + with_unit(-case_.schedule.hold, "s") + " to " +
                             with_unit(case_.time.end, "s"));
  }

  void monitor(std::size_t index) {
    const Monitor& m = case_.monitors[index];
    const std::string field = "monitor[" + std::to_string(index) + "]";
    for (std::size_t j = 0; j < index; ++j) {
      if (case_.monitors[j].name == m.name) {
        fault(field + ".name", m.name, "is the name of an earlier monitor", "a name of its own",
              "rename it");
      }
    }
    case_.section.file.empty() ? beside_or_above(field, m) : outside_the_mesh(field, m);
  }

  void beside_or_above(const std::string& field, const Monitor& m) {
    if (sound({field + ".x", "section.half_width"}) &&
        m.x > case_.section.half_width + round_off) {
      fault(field + ".x", with_unit(m.x, "m"), "lies outside the slab",
            "0 m to section.half_width = " + with_unit(case_.section.half_width, "m"),
            "move the monitor");
    }
    if (sound({field + ".y"}) && sound(course_keys) && m.y > *final_level_ + round_off) {
      fault(field + ".y", with_unit(m.y, "m"), "lies outside the slab",
            "0 m to the final metal level, " + with_unit(*final_level_, "m"), "move the monitor");
    }
  }

  void outside_the_mesh(const std::string& field, const Monitor& m) {
    if (!sound({field + ".x", field + ".y", "mesh.file", "mesh.element"})) return;
    if (locate(*imported_, m.x, m.y)) return;
    fault(field + ".y", with_unit(m.y, "m"), "lies outside the slab",
          "a point of the imported mesh", "move the monitor");
  }

  void advice() {
    if (case_.monitors.empty()) {
      result_.warnings.add("monitor", "", "there is no monitor: no displacement will be reported", "",
                           "add a [[monitor]] table");
    }
    if (case_.mechanics.enabled && sound({"mechanics.start", "time.end"}) &&
        case_.mechanics.start > case_.time.end) {
      result_.warnings.add("mechanics.start", with_unit(case_.mechanics.start, "s"),
                           "lies after the end: the mechanics never starts");
    }
  }

  const Case& case_;
  const std::vector<std::string>& faulty_keys_;
  CheckedCase result_;
  std::set<std::string> waited_for_;
  std::optional<double> final_level_;     ///< [m]; there when the course is sound
  std::optional<mesh::Mesh2D> imported_;  ///< there when mesh.file is sound
};

}  // namespace

CheckedCase check(const Case& casting_case, const std::vector<std::string>& faulty_keys) {
  return CaseCheck(casting_case, faulty_keys).all();
}

}  // namespace dccast::casting
