#include <algorithm>
#include <cmath>
#include <cstdio>

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

/// Checks one case; each member adds its faults.
class CaseCheck {
public:
  explicit CaseCheck(const Case& c) : case_(c) {}

  CheckedCase all() {
    alloy();
    zones();
    curves();
    section();
    time();
    mechanics();
    if (result_.faults.empty()) sizes();
    if (result_.faults.empty()) files_and_monitors();
    if (result_.faults.empty()) advice();
    return std::move(result_);
  }

private:
  template <class... Rest>
  void fault(Rest&&... rest) { result_.faults.add(std::forward<Rest>(rest)...); }

  void alloy() {
    const material::AlloyCard& a = case_.alloy;
    if (a.solidus > a.liquidus) {
      fault("alloy.solidus", with_unit(a.solidus, "degC"), "lies above the liquidus",
            "at most alloy.liquidus = " + with_unit(a.liquidus, "degC"),
            "exchange the two, or make them equal for a pure metal");
    }
    if (a.coherency > a.liquidus || a.coherency < a.solidus - 100.0) {
      fault("alloy.coherency", with_unit(a.coherency, "degC"),
            "is not a temperature of the mush",
            "up to alloy.liquidus = " + with_unit(a.liquidus, "degC") +
                ", not more than 100 K below alloy.solidus = " + with_unit(a.solidus, "degC"),
            "leave it out to take the liquidus");
    }
    if (!a.liquid_fraction.empty()) liquid_fraction();
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
      if (zone.to <= zone.from) {
        fault(field + ".to", with_unit(zone.to, "m"), "does not lie below the zone's upper edge",
              "more than " + field + ".from = " + with_unit(zone.from, "m"), "exchange from and to");
      }
      for (std::size_t j = 0; j < i; ++j) {
        const thermal::SideZone& other = case_.cooling.zones[j];
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
    if (!s.file.empty() && s.growth) {
      fault("mesh.growth", "true", "an imported mesh cannot grow", "false with mesh.file",
            "write growth = false, or leave mesh.file out");
    }
    if (case_.cooling.top == thermal::Top::insulated && s.growth) {
      fault("cooling.top", "insulated", "metal is poured in at the top of a slab that grows",
            "pouring, or mesh.growth = false", "write top = \"pouring\"");
    }
    if (!case_.thermal.file.empty() && s.growth) {
      fault("thermal.file", case_.thermal.file.filename().string(),
            "has one temperature a node, and a slab that grows has ever more nodes",
            "mesh.growth = false with thermal.file", "write growth = false in [mesh]");
    }
    const double cell = s.growth_cell.value_or(s.initial_depth / s.rows);
    if (s.growth && cell > s.initial_depth) {
      fault("mesh.growth_cell", with_unit(cell, "m"), "is higher than the metal at the start",
            "at most section.initial_depth = " + with_unit(s.initial_depth, "m"),
            "choose smaller growth cells");
    }
    if (s.file.empty() && s.side_cell > s.half_width) {
      fault("mesh.side_cell", with_unit(s.side_cell, "m"), "is wider than the section",
            "at most section.half_width = " + with_unit(s.half_width, "m"), "choose a smaller cell");
    }
    if (s.file.empty() && s.bottom_cell > s.initial_depth) {
      fault("mesh.bottom_cell", with_unit(s.bottom_cell, "m"), "is higher than the metal",
            "at most section.initial_depth = " + with_unit(s.initial_depth, "m"),
            "choose a smaller cell");
    }
    const bool conical = case_.section.kind == mesh::SectionKind::axisymmetric;
    if (conical && case_.mechanics.enabled) {
      fault("mechanics.enabled", "true", "an axisymmetric section has heat only",
            "false with section.kind = \"axisymmetric\"", "write enabled = false in [mechanics]");
    }
  }

  void time() {
    if (case_.time.end <= -case_.schedule.hold) {
      fault("time.end", with_unit(case_.time.end, "s"), "does not lie after the beginning",
            "more than " + with_unit(-case_.schedule.hold, "s") + ", minus schedule.hold",
            "move the end");
    }
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
    if (case_.mechanics.options.algorithm == mechanics::Algorithm::sbm && product >= 1.0) {
      fault("mechanics.parameters.lambda_p", p.lambda_p.value_or(0.0),
            "times gamma_p is not below 1 (Lemma 3)", "less than 1 / gamma_p",
            "leave it out to take 1 / (2 gamma_p)");
    }
  }

  void sizes() {
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
    }
    final_level_ = case_.section.initial_depth + (case_.section.growth ? length : 0.0);
    result_.estimate.steps = steps;
    if (case_.section.file.empty()) built_in_size();
  }

  void built_in_size() {
    const mesh::SectionSpec& s = case_.section;
    const double cell = s.growth_cell.value_or(s.initial_depth / s.rows) / s.refinement;
    // Before any mesh is built: a growth cell of micrometres must not be tried.
    const double rough = (s.rows * s.refinement + (final_level_ - s.initial_depth) / cell) *
                         (s.columns * s.refinement + 1.0);
    if (rough > 2.0 * static_cast<double>(case_.limits.maximum_nodes)) return too_many_nodes(rough);
    const std::int64_t rows = mesh::rows_at(s, final_level_);
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

  void files_and_monitors() {
    mesh::Mesh2D mesh;
    if (case_.section.file.empty()) {
      mesh = mesh::SlabMesh(case_.section).mesh();
    } else {
      auto read = mesh::read_gmsh<2>(case_.section.file, case_.section.element, result_.faults);
      if (!read) return;
      mesh = std::move(*read);
      result_.estimate.nodes = mesh.nodes();
      result_.estimate.elements = mesh.elements();
      if (mesh.nodes() > case_.limits.maximum_nodes) too_many_nodes(mesh.nodes());
      effort();
    }
    if (!case_.thermal.file.empty()) {
      const auto history = results::read_temperature_file(
          case_.thermal.file, std::size_t(mesh.nodes()), result_.faults);
      if (history) temperature_range(*history);
    }
    for (std::size_t i = 0; i < case_.monitors.size(); ++i) monitor(i, mesh);
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

  void monitor(std::size_t index, const mesh::Mesh2D& mesh) {
    const Monitor& m = case_.monitors[index];
    const std::string field = "monitor[" + std::to_string(index) + "]";
    for (std::size_t j = 0; j < index; ++j) {
      if (case_.monitors[j].name == m.name) {
        fault(field + ".name", m.name, "is the name of an earlier monitor", "a name of its own",
              "rename it");
      }
    }
    if (locate(mesh, m.x, m.y)) return;
    const bool built_in = case_.section.file.empty();
    if (built_in && m.x <= case_.section.half_width && m.y <= final_level_) return;
    if (built_in && m.x > case_.section.half_width) {
      fault(field + ".x", with_unit(m.x, "m"), "lies outside the slab",
            "0 m to section.half_width = " + with_unit(case_.section.half_width, "m"),
            "move the monitor");
      return;
    }
    fault(field + ".y", with_unit(m.y, "m"), "lies outside the slab",
          built_in ? "0 m to the final metal level, " + with_unit(final_level_, "m")
                   : std::string("a point of the imported mesh"),
          "move the monitor");
  }

  void advice() {
    if (case_.monitors.empty()) {
      result_.warnings.add("monitor", "", "there is no monitor: no displacement will be reported", "",
                           "add a [[monitor]] table");
    }
    if (case_.mechanics.enabled && case_.mechanics.start > case_.time.end) {
      result_.warnings.add("mechanics.start", with_unit(case_.mechanics.start, "s"),
                           "lies after the end: the mechanics never starts");
    }
  }

  const Case& case_;
  CheckedCase result_;
  double final_level_ = 0.0;
};

}  // namespace

CheckedCase check(const Case& casting_case) { return CaseCheck(casting_case).all(); }

}  // namespace dccast::casting
