#include <algorithm>
#include <cmath>

#include "core/casting/slab_run.hpp"
#include "core/material/mechanical_properties.hpp"
#include "dccast/v1/case.pb.h"
#include "tests/support/load_case.hpp"
#include "tests/verification/mechanics/figures.hpp"
#include "tests/verification/program/casting_run.hpp"
#include "tests/verification/program/discussion.hpp"
#include "tests/verification/program/plot.hpp"

namespace dccast::verification {

namespace {

using Run2D = casting::SlabRun<2>;
using Run3D = casting::SlabRun<3>;

std::string section(const std::string& title, const std::string& setup, const std::string& plots,
                    const std::string& after = {}) {
  return "<section><h2>" + title + "</h2><p class=\"setup\">" + setup +
         "</p><div class=\"plots\">" + plots + "</div>" + after + "</section>\n";
}

std::string format(const char* pattern, double a, double b = 0.0) {
  char text[240];
  std::snprintf(text, sizeof text, pattern, a, b);
  return text;
}

/// Advances a run to a time [s], or until it has used its processor time. @return a monitor's curl
/// [mm] by time [s]
template <int Dim>
std::vector<std::pair<double, double>> advance(casting::SlabRun<Dim>& run, double time,
                                               double limit, std::size_t monitor = 0) {
  std::vector<std::pair<double, double>> curl;
  const double start = cpu_seconds();
  while (!run.finished() && run.time() < time - 1e-9 && cpu_seconds() - start < limit) {
    const auto report = run.advance();
    const double lift = report.monitor_displacement.at(monitor).at(Dim - 1);
    if (std::isfinite(lift)) curl.emplace_back(report.time, 1e3 * lift);
  }
  return curl;
}

/// Outlines of a section, moved by its displacement times `magnified`.
std::vector<Polygon> outlines(const mesh::Mesh2D& mesh) {
  std::vector<Polygon> polygons;
  for (int e = 0; e < mesh.elements(); ++e) {
    Polygon polygon;
    for (int i = 0; i < mesh.nodes_per_element; ++i) {
      const double* p = mesh.point(mesh.nodes_of(e)[i]);
      polygon.push_back({p[0], p[1]});
    }
    polygons.push_back(polygon);
  }
  return polygons;
}

/// The faces of a quarter slab seen from outside its corner, a little from above. @param u  (node,
/// coordinate) [m]; empty: undeformed
std::vector<Polygon> outlines(const mesh::Mesh3D& mesh, const std::vector<double>& u,
                              double magnified) {
  std::vector<Polygon> polygons;
  for (const auto kind : {mesh::PatchKind::top, mesh::PatchKind::side}) {
    mesh::for_each_facet(mesh, kind, [&](const auto& facet, const auto&) {
      Polygon polygon;
      for (int i = 0; i < facet.nodes; ++i) {
        const int n = facet.node[std::size_t(i)];
        double p[3];
        for (int d = 0; d < 3; ++d)
          p[d] = mesh.point(n)[d] + (u.empty() ? 0.0 : magnified * u[std::size_t(3 * n + d)]);
        // x to the left and y to the right, both towards the reader.
        polygon.push_back({0.9 * (p[1] - p[0]), p[2] - 0.35 * (p[0] + p[1])});
      }
      polygons.push_back(polygon);
    });
  }
  return polygons;
}

std::string creep_section() {
  const material::AlloyCard card = support::load_case(casting_name).alloy;
  const material::MechanicalProperties metal(card);
  constexpr double temperature = 500.0, q = 6.0, minutes = 10.0;
  std::vector<Curve2D> curves;
  for (const double stress : {20e6, 30e6, 40e6}) {
    // Uniaxial: |s| = sqrt(2/3) sigma, and the axial part of s is 2/3 sigma.
    const double rate = metal.creep().kappa(temperature) *
                        std::pow(std::sqrt(2.0 / 3.0) * stress, q - 2.0) * 2.0 / 3.0 * stress;
    const double elastic = stress / card.young_modulus(temperature);
    curves.push_back({format("%.0f MPa", 1e-6 * stress),
                      {{0.0, 0.0},
                       {0.0, 100.0 * elastic},
                       {minutes, 100.0 * (elastic + 60.0 * minutes * rate)}}});
  }
  return section("Creep at constant stress (the paper's figure 6)",
                 "The paper's alloy at 500 °C: elastic strain, then secondary creep at a constant "
                 "rate. Neither law has the third stage, which ends in fracture.",
                 chart_svg("strain [%]", "time [min]", curves));
}

std::string start_of_slab_section(double limit) {
  Run3D run(support::load_case("start-3d-paper", v1::DRAFT));
  const std::string mesh =
      outlines_svg("figure 16: the mesh at the start", outlines(run.mesh(), {}, 1.0));
  auto curl = advance(run, 140.0, limit);
  const auto frame = run.take_frame();
  const std::string curled = outlines_svg("figure 17, left: at 140 s, displacement x 5",
                                          outlines(run.mesh(), frame.displacement, 5.0));
  const auto rest = advance(run, 250.0, limit);
  curl.insert(curl.end(), rest.begin(), rest.end());
  const double last = curl.empty() ? NAN : curl.back().second;
  const std::string history = chart_svg("figure 17, right: corner [mm]", "time [s]",
                                        {{"computed here", curl},
                                         {"computed in the paper", {{250.0, 35.0}}},
                                         {"measured", {{250.0, 38.0}}}});
  return section(
      "Start of a slab (the paper's figures 16 and 17)",
      "`start-3d-paper` at draft: a quarter of a slab whose size, recipe and thermal data are "
      "assumed, as the paper prints none.",
      mesh + curled + history,
      format("<p class=\"remarks\">%.1f mm at %.0f s. The paper shows the modulus of the "
             "displacement against time; the two points are the figures of its text.</p>",
             last, run.time()));
}

/// Half thicknesses of the wide face at a height, and the opening of the mould there.
struct FaceRow {
  double height = 0.0;                           ///< [m]
  std::vector<std::pair<double, double>> slab;   ///< (x [m], half thickness [mm])
  std::vector<std::pair<double, double>> mould;  ///< (x [m], half opening [mm])

  /// [%] of the opening by which the slab is narrower.
  double pull_in(std::size_t point) const {
    return 100.0 * (1.0 - slab[point].second / mould[point].second);
  }
};

FaceRow face_at(const casting::Case& c, const Run3D& run, const std::vector<double>& u,
                double wanted) {
  const auto& mesh = run.mesh();
  const auto on_face = [&](int n) {
    const double* p = mesh.point(n);
    return std::abs(p[1] - c.section.half_thickness(p[0])) < 1e-6;
  };
  FaceRow row;
  row.height = NAN;
  for (int n = 0; n < mesh.nodes(); ++n) {
    const double z = mesh.point(n)[2];
    if (on_face(n) && !(std::abs(z - wanted) >= std::abs(row.height - wanted))) row.height = z;
  }
  for (int n = 0; n < mesh.nodes(); ++n) {
    const double* p = mesh.point(n);
    if (!on_face(n) || std::abs(p[2] - row.height) > 1e-6) continue;
    row.slab.emplace_back(p[0], 1e3 * (p[1] + u[std::size_t(3 * n + 1)]));
    row.mould.emplace_back(p[0], 1e3 * c.section.half_thickness(p[0]));
  }
  std::ranges::sort(row.slab);
  std::ranges::sort(row.mould);
  return row;
}

constexpr double heights[] = {0.05, 0.25, 0.45};  // [m] lower region, halfway, head of the solid

std::string stationary_section(double limit) {
  casting::Case c = support::load_case("stationary-3d", v1::DRAFT);
  Table table;
  table.title = "Influence of the start on the steady faces (section 5.1, Saint-Venant)";
  table.setup =
      "`stationary-3d` at draft, hot, with Signorini contact and the curl of its start, and with "
      "the butt held on the block, so that it does not curl: pull-in of the wide face [%].";
  table.columns = {"height [m]",   "middle, contact", "middle, held", "difference",
                   "end, contact", "end, held",       "difference "};
  std::vector<FaceRow> with_contact;
  std::vector<std::vector<Cell>> rows(std::size(heights));
  std::string mesh, chart;
  double reached = 0.0;
  for (const bool contact : {true, false}) {
    c.mechanics.options.contact = contact;
    Run3D run(c);
    advance(run, c.time.end, limit);
    reached = run.time();
    const auto u = run.take_frame().displacement;
    if (contact) {
      mesh = outlines_svg("figure 18, left: the mesh", outlines(run.mesh(), {}, 1.0)) +
             outlines_svg("figure 18, right: displacement x 10", outlines(run.mesh(), u, 10.0));
    }
    for (std::size_t i = 0; i < std::size(heights); ++i) {
      const FaceRow row = face_at(c, run, u, heights[i]);
      if (contact) {
        with_contact.push_back(row);
        continue;
      }
      const FaceRow& other = with_contact[i];
      const std::size_t end = row.slab.size() - 1;
      rows[i] = {row.height,
                 other.pull_in(0),
                 row.pull_in(0),
                 row.pull_in(0) - other.pull_in(0),
                 other.pull_in(end),
                 row.pull_in(end),
                 row.pull_in(end) - other.pull_in(end)};
    }
  }
  table.rows = rows;
  table.remarks.push_back(format(
      "Evaluated at %.0f s. The paper replaces the contact by a constraint, as the curl has no "
      "influence; ours reaches up to about half a thickness of the slab.",
      reached));
  if (reached < c.time.end - 1.0) {
    table.remarks.push_back(
        "Given up by --limit: the highest row is still liquid and says nothing.");
  } else {
    table.remarks.push_back(
        format("At the highest row they differ by %.2f %% of the opening in the middle and %.2f %% "
               "at the end.",
               std::abs(rows.back()[3].get<double>()), std::abs(rows.back()[6].get<double>())));
  }

  std::vector<Curve2D> profiles{{"mould", with_contact.front().mould},
                                {"wanted", {{0.0, 285.0}, {c.section.half_width, 285.0}}}};
  for (const FaceRow& row : with_contact)
    profiles.push_back({format("slab at %.2f m", row.height), row.slab});
  return section("The stationary stage (the paper's figures 18 and 19)",
                 "`stationary-3d` at draft: slab, mould and recipe are assumed. Half thicknesses "
                 "are hot, at the time of the picture.",
                 mesh + chart_svg("figure 19: half thickness [mm]", "x [m]", profiles)) +
         to_html(table);
}

std::string section_of_start(double limit) {
  Run2D run(shipped_casting(mesh::ElementKind::p1));
  const std::string mesh = outlines_svg("figure 20: the mesh at the start", outlines(run.mesh()));
  const auto curl = advance(run, 145.0, limit);
  const auto frame = run.take_frame();
  mesh::Mesh2D curled = run.mesh();
  for (std::size_t i = 0; i < curled.node.size(); ++i)
    curled.node[i] += 5.0 * frame.displacement[i];
  std::vector<double> temperature;
  for (int e = 0; e < curled.elements(); ++e)
    temperature.push_back(mesh::mean_at_nodes<2>(curled, e, frame.temperature));
  return section(
      "Start of a thickness section (the paper's figures 20 and 21)",
      "`start-2d-thickness` on 1320 triangles, the paper's number.",
      mesh +
          field_svg("figure 21: at 145 s, displacement x 5", curled, temperature, 700.0, "[°C]") +
          chart_svg("first monitor [mm]", "time [s]", {{"computed here", curl}}));
}

}  // namespace

std::string casting_figures(const TableOptions& options) {
  return creep_section() + start_of_slab_section(options.limit) +
         stationary_section(options.limit) + section_of_start(options.limit);
}

}  // namespace dccast::verification
