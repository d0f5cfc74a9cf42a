#pragma once

#include <cmath>
#include <string>
#include <utility>

#include "core/results/frame.hpp"
#include "core/results/result_writer.hpp"
#include "core/results/step_report.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::results {

inline RunHeader sample_header() {
  RunHeader header;
  header.program_version = "0.1.0";
  header.build = "a compiler";
  header.commit = "0123456789abcdef";
  header.case_sha256 = "5ca1ab1e";
  header.title = "butt <of> a & \"slab\"";
  header.case_json = R"({"title": "butt"})";
  header.section = "plane_strain";
  header.liquidus = 649.0;
  header.solidus = 620.0;
  header.relative_curl_error = 0.02;
  header.monitor_name = {"corner", "centre \xC2\xB5"};
  header.monitor_position = {{0.28, 0.0}, {0.0, 0.0}};
  return header;
}

/// Irrational values, so that every lost bit is detected.
inline StepReport sample_step(std::int64_t step) {
  StepReport report;
  const double s = static_cast<double>(step);

  report.step = step;
  report.time = s / 3.0;
  report.time_step = 1.0 / 3.0;
  report.cast_length = 1e-3 * std::sqrt(s);

  report.iterations = static_cast<int>(step % 7);
  report.heat_iterations = static_cast<int>(step % 5);
  report.contact_changes = static_cast<int>(step % 3);
  report.monitor_displacement = {{std::sin(s), std::cos(s)}, {std::exp(-s), std::sqrt(s)}};
  report.monitor_temperature = {600.0 + std::sin(s), 500.0 + std::cos(s)};

  report.side_heat = 5e5 + s / 7.0;
  report.bottom_heat = 2e5;
  report.conjugate_gradient_iterations = static_cast<int>(step % 11);
  report.equilibrium_residual = 1e-7 / (1.0 + s);
  report.wall_heat_flux = 7e5 + s / 7.0;
  report.maximum_rotation = 0.01 * std::sqrt(s);
  report.bottom_slip = 1e-4 / (1.0 + s);

  report.shell_at_water_line = 0.03 / (1.0 + s);
  report.bottom_shell = 0.02 * std::sqrt(s);
  report.mush_strain = 1e-3 * s / 7.0;
  report.least_shell = 0.02 / (1.0 + s);
  report.least_shell_depth = 0.03;
  report.tear_rate = 1e-4 * s;
  report.tear_pressure_surface = 1e4 / (1.0 + s);
  report.pore_volume = 1e-6 * s;
  report.beyond_validity = step > 290;

  report.solver_seconds = 0.25;
  report.process_seconds = 0.5;
  report.nodes = 6 + 2 * step;
  report.elements = 4;

  return report;
}

/// A strip of `cells` quadrilaterals, or twice as many triangles.
inline Frame sample_frame(std::int64_t step, int nodes_per_element, int cells) {
  Frame frame;
  frame.step = step;
  frame.time = static_cast<double>(step) / 3.0;
  frame.cast_length = 1e-3 * std::sqrt(static_cast<double>(step));
  frame.metal_level = 0.1 + frame.cast_length;
  frame.nodes_per_element = nodes_per_element;

  // A lower and an upper row of nodes, and cells between them.
  for (int i = 0; i <= cells; ++i)
    for (const double height : {0.0, 0.1}) frame.node.insert(frame.node.end(), {0.01 * i, height});
  for (int i = 0; i < cells; ++i) {
    const int a = 2 * i, b = a + 2, c = a + 3, d = a + 1;
    if (nodes_per_element == 4) frame.element_node.insert(frame.element_node.end(), {a, b, c, d});
    if (nodes_per_element == 3)
      frame.element_node.insert(frame.element_node.end(), {a, b, c, a, c, d});
  }

  // Fields at nodes, at nodes of the bottom and at elements.
  for (std::int64_t n = 0; n < frame.nodes(); ++n) {
    const double value = std::sin(static_cast<double>(n + step));
    frame.temperature.push_back(600.0 + 100.0 * value);
    frame.liquid_fraction.push_back(value * value);
    frame.displacement.insert(frame.displacement.end(), {1e-3 * value, -1e-4 * value});
    frame.thermal_strain.push_back(-0.01 * value * value);
    if (n % 2 == 0) {
      frame.bottom_node.push_back(static_cast<std::int32_t>(n));
      frame.bottom_gap.push_back(std::abs(value) / 3.0);
      frame.bottom_pressure.push_back(0.0);
    }
  }

  for (std::int64_t i = 0; i < 4 * frame.elements(); ++i) {
    frame.stress.push_back(1e6 / static_cast<double>(i + 1 + step));
    frame.viscoplastic_strain.push_back(1e-3 / static_cast<double>(i + 1 + step));
  }
  for (std::int64_t i = 0; i < frame.elements(); ++i) {
    frame.tear_rate.push_back(1e-4 / static_cast<double>(i + 1 + step));
    frame.tear_pressure.push_back(1e4 / static_cast<double>(i + 1 + step));
  }

  return frame;
}

/// A row of `cells` hexahedra of 10 mm with fields of its own.
inline Frame sample_solid_frame(std::int64_t step, int cells) {
  Frame frame;
  frame.step = step;
  frame.time = static_cast<double>(step) / 3.0;
  frame.dimension = 3;
  frame.nodes_per_element = 8;

  // Four nodes in each plane, and cells between the planes.
  for (int i = 0; i <= cells; ++i) {
    const double x = 0.01 * i;
    for (const auto& [y, z] : {std::pair{0.0, 0.0}, {0.01, 0.0}, {0.01, 0.01}, {0.0, 0.01}})
      frame.node.insert(frame.node.end(), {x, y, z});
  }
  for (int i = 0; i < cells; ++i) {
    const int a = 4 * i, b = a + 4;
    for (const int n : {a, b, b + 1, a + 1, a + 3, b + 3, b + 2, a + 2})
      frame.element_node.push_back(n);
  }

  // Fields at nodes, at nodes of the bottom and at elements.
  for (std::int64_t n = 0; n < frame.nodes(); ++n) {
    const double value = std::sin(static_cast<double>(n + step));
    frame.temperature.push_back(600.0 + 100.0 * value);
    frame.liquid_fraction.push_back(value * value);
    frame.displacement.insert(frame.displacement.end(), {1e-3 * value, -1e-4 * value, 2e-3});
    if (n % 4 > 1) continue;
    frame.bottom_node.push_back(static_cast<std::int32_t>(n));
    frame.bottom_gap.push_back(std::abs(value) / 3.0);
    frame.bottom_pressure.push_back(1e3 * value * value);
  }

  for (std::int64_t i = 0; i < 6 * frame.elements(); ++i) {
    frame.stress.push_back(1e6 / static_cast<double>(i + 1 + step));
    frame.viscoplastic_strain.push_back(1e-3 / static_cast<double>(i + 1 + step));
  }
  return frame;
}

/// The header and the step of a run of such frames.
inline RunHeader sample_solid_header() {
  RunHeader header = sample_header();
  header.section = "quarter_slab";
  header.dimension = 3;
  header.relative_curl_error.reset();
  header.monitor_position = {{0.28, 0.1, 0.0}, {0.0, 0.0, 0.0}};
  return header;
}

inline StepReport sample_solid_step(std::int64_t step) {
  StepReport report = sample_step(step);
  for (auto& displacement : report.monitor_displacement) displacement.push_back(1e-3);
  report.contact_area = 0.01;
  report.dimension = 3;
  return report;
}

}  // namespace dccast::results
