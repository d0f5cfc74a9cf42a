#include "proto/case_file/quality.hpp"

#include <google/protobuf/util/message_differencer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "proto/case_file/case_file.hpp"

namespace dccast::case_file {
namespace {

using google::protobuf::util::MessageDifferencer;

/// A length of time steps, from a time after an event on.
struct Rung {
  double after;  ///< [s]
  double step;   ///< [s]
};
using Ladder = std::vector<Rung>;

/// How far the true curl may lie below and above the computed one, relative to it [1].
struct Band {
  double below, above;
};

/// Mesh and time steps of a quality for a kind of section. Lengths in m.
struct Discretisation {
  double column;                                ///< width
  int fewest_columns = 8;                       ///< regardless of the width
  double layer = 0.0;                           ///< of a quarter slab
  int heat_per_column = 1, heat_per_layer = 1;  ///< cells of the heat, of a quarter slab
  double bottom_cell, top_cell;      ///< heights of the lowest and the topmost initial row
  double growth_cell;                ///< height of the rows that growth adds
  double merge_below = 0.0;          ///< depth at which these rows are merged; 0: never
  Ladder begin{{0, 0.25}, {10, 1}};  ///< steps from the start of the simulation
  Ladder event;  ///< steps from the start of casting, of the mechanics, and of the water
  Band error;    ///< of the final curl
};

const Discretisation& section_discretisation(v1::Quality quality) {
  static const Discretisation draft{.column = 14e-3,
                                    .bottom_cell = 3.5e-3,
                                    .top_cell = 7e-3,
                                    .growth_cell = 7e-3,
                                    .begin = {{0, 1}, {10, 4}},
                                    .event = {{0, 0.2}, {2, 0.5}, {10, 1}, {30, 2}},
                                    .error = {0.05, 0.05}};

  static const Discretisation engineering{.column = 9.4e-3,
                                          .bottom_cell = 2.25e-3,
                                          .top_cell = 2.25e-3,
                                          .growth_cell = 5e-3,
                                          .event = {{0, 0.05}, {2, 0.125}, {10, 0.25}, {30, 1}},
                                          .error = {0.04, 0.04}};

  static const Discretisation fine{
      .column = 7e-3,
      .bottom_cell = 1.5e-3,
      .top_cell = 1.5e-3,
      .growth_cell = 3.5e-3,
      .event = {{0, 0.025}, {1, 0.05}, {3, 0.125}, {10, 0.25}, {30, 0.5}, {60, 1}},
      .error = {0.04, 0.04}};

  return quality == v1::DRAFT ? draft : quality == v1::FINE ? fine : engineering;
}

/// The heat needs narrow cells in plan, since a wide cell stays hot at the surface and gives off
/// too much heat; the mechanics needs even ones, since the widest decides. So the heat divides the
/// mechanics' cells, and these are few, for their cost grows with the square of their number. The
/// lowest rows resolve the shell over the block, which is 4 to 15 mm thick in the first minute.
/// Rows that growth adds have little effect; deep ones are merged. Steps grow as the curl slows
/// down. The runs on which this is based are in docs/developers/discretisation.md.
const Discretisation& quarter_slab_discretisation(v1::Quality quality) {
  static const Ladder filling{{0, 2}, {10, 8}}, start{{0, 0.5}, {2, 2}, {150, 5}, {300, 10}};
  static const Discretisation draft{.column = 94e-3,
                                    .fewest_columns = 6,
                                    .layer = 36e-3,
                                    .heat_per_column = 3,
                                    .heat_per_layer = 2,
                                    .bottom_cell = 4e-3,
                                    .top_cell = 7e-3,
                                    .growth_cell = 10e-3,
                                    .merge_below = 0.1,
                                    .begin = filling,
                                    .event = start,
                                    .error = {0.04, 0.08}};

  static const Discretisation engineering{.column = 82e-3,
                                          .fewest_columns = 7,
                                          .layer = 31.5e-3,
                                          .heat_per_column = 4,
                                          .heat_per_layer = 2,
                                          .bottom_cell = 3e-3,
                                          .top_cell = 3.9e-3,
                                          .growth_cell = 10e-3,
                                          .merge_below = 0.1,
                                          .begin = filling,
                                          .event = start,
                                          .error = {0.05, 0.05}};

  static const Discretisation fine{.column = 55e-3,
                                   .fewest_columns = 10,
                                   .layer = 28e-3,
                                   .heat_per_column = 4,
                                   .heat_per_layer = 2,
                                   .bottom_cell = 2.5e-3,
                                   .top_cell = 3e-3,
                                   .growth_cell = 8e-3,
                                   .merge_below = 0.1,
                                   .event = {{0, 0.25}, {2, 0.5}, {150, 1}, {300, 2}},
                                   .error = {0.05, 0.05}};

  return quality == v1::DRAFT ? draft : quality == v1::FINE ? fine : engineering;
}

/// The error of a figure that findings judge: that of starts of several alloys and sizes against
/// their truths, rounded outwards (docs/error-bars.md).
struct MeasuredFigure {
  const char* figure;  ///< as in core/casting/findings/rules_of_step.cpp
  bool is_relative;
  Band draft, finer;  ///< engineering and fine
};
constexpr std::array measured_figures{
    MeasuredFigure{"shell over the block", true, {0.30, 0.10}, {0.07, 0.35}},
    MeasuredFigure{"shell at the mould exit", true, {0.05, 0.10}, {0.04, 0.10}},
    MeasuredFigure{"surface at the mould exit", false, {6.0, 5.0}, {16.0, 6.0}},
    MeasuredFigure{"shell above the water", true, {0.52, 0.07}, {0.46, 0.13}},
    MeasuredFigure{"depth at which the side freezes", true, {0.04, 0.105}, {0.07, 0.06}},
    MeasuredFigure{"share of the sump", true, {0.025, 0.025}, {0.022, 0.035}},
    MeasuredFigure{"rotation", true, {0.01, 0.10}, {0.015, 0.05}},
    MeasuredFigure{"lift of the butt", true, {0.04, 0.08}, {0.05, 0.05}},
};

const Discretisation& choose_discretisation(const v1::Case& c) {
  return c.section().kind() == v1::Section::QUARTER_SLAB ? quarter_slab_discretisation(c.quality())
                                                         : section_discretisation(c.quality());
}

/// The nearest number of cells within the limits of the schema; of a NaN the fewest. What is wrong
/// with a case is told after its completion.
int limited_count(double cells, int fewest) {
  constexpr double most = 1000.0;
  return cells > fewest ? static_cast<int>(std::min(std::round(cells), most)) : fewest;
}

void fill_columns(const Discretisation& d, double half_width, v1::Mesh& mesh) {
  if (!mesh.has_columns()) mesh.set_columns(limited_count(half_width / d.column, d.fewest_columns));
  if (!mesh.has_side_cell_m()) mesh.set_side_cell_m(half_width / mesh.columns());
}

void fill_layers(const Discretisation& d, const v1::Curve& half_thickness, v1::Mesh& mesh) {
  constexpr int fewest = 3;
  const double end = *std::prev(half_thickness.value().end());
  if (!mesh.has_layers()) mesh.set_layers(limited_count(end / d.layer, fewest));
  if (!mesh.has_wide_side_cell_m() && end > 0.0) mesh.set_wide_side_cell_m(end / mesh.layers());
}

/// A case that gives its own plan has the heat on it too, unless it asks for more: what it says is
/// the mesh that it gets. Cases that were completed before the heat could have cells of its own say
/// so, too.
void fill_heat_cells(const Discretisation& d, bool own_plan, v1::Mesh& mesh) {
  const bool same = own_plan || mesh.element() == v1::P1 || !mesh.file().empty();
  if (!mesh.has_heat_cells_per_column())
    mesh.set_heat_cells_per_column(same ? 1 : d.heat_per_column);
  if (!mesh.has_heat_cells_per_layer()) mesh.set_heat_cells_per_layer(same ? 1 : d.heat_per_layer);
}

/// Number of rows whose heights grow geometrically over a depth, from the lowest to about the
/// topmost height [m].
int count_graded_rows(double depth, double lowest, double topmost) {
  constexpr int fewest = 4;
  if (depth < 2.0 * (lowest + topmost)) return fewest;

  const double ratio = (depth - lowest) / (depth - topmost);
  const double rows = std::abs(ratio - 1.0) < 1e-6
                          ? depth / lowest
                          : 1.0 + std::log(topmost / lowest) / std::log(ratio);
  return limited_count(rows, fewest);
}

/// If the case gives its own rows, growth continues in their height.
void fill_rows(const Discretisation& d, double depth, v1::Mesh& mesh) {
  if (!mesh.has_growth_cell_m() && !mesh.has_rows())
    mesh.set_growth_cell_m(std::min(d.growth_cell, depth));

  const double lowest = mesh.has_bottom_cell_m() ? mesh.bottom_cell_m() : d.bottom_cell;
  if (!mesh.has_rows())
    mesh.set_rows(count_graded_rows(depth, lowest, std::max(lowest, d.top_cell)));
  if (!mesh.has_bottom_cell_m())
    mesh.set_bottom_cell_m(std::min(d.bottom_cell, depth / mesh.rows()));
}

/// If the case gives the heights of its rows, they are merged only on request. Rows are merged up
/// to four growth cells, at most 15 mm, but at least to two growth cells.
void fill_merging(const Discretisation& d, bool own_rows, v1::Mesh& mesh) {
  constexpr double highest = 15e-3;  // [m]
  if (!mesh.has_merge_below_m())
    mesh.set_merge_below_m(own_rows || mesh.element() == v1::P1 ? 0.0 : d.merge_below);
  if (!mesh.has_merged_cell_m() && mesh.has_growth_cell_m())
    mesh.set_merged_cell_m(
        std::max(2.0 * mesh.growth_cell_m(), std::min(highest, 4.0 * mesh.growth_cell_m())));
}

/// Whether the file of a mesh is a plan with rows of cells above it, or there is no file.
bool has_rows(const v1::Case& c) {
  const bool grows = !c.mesh().has_growth() || c.mesh().growth();
  return c.mesh().file().empty() || (grows && c.section().kind() == v1::Section::QUARTER_SLAB);
}

/// Adds the steps of a ladder that begins at a time. Tables are interpolated linearly, and steps
/// end at their points; therefore each length is repeated one step before the next one begins.
void add_steps(double begin, const Ladder& ladder, double end, v1::Curve& curve) {
  for (const auto& [after, step] : ladder) {
    const double from = begin + after;
    if (from >= end) break;

    if (curve.value_size() > 0) {
      const double last = *std::prev(curve.value().end());
      if (from - last > *std::prev(curve.at().end())) {
        curve.add_at(from - last);
        curve.add_value(last);
      }
    }

    curve.add_at(from);
    curve.add_value(step);
  }
}

/// Times of sudden events after the start of the simulation, ascending [s]: casting, mechanics,
/// water.
std::vector<double> sudden_events(const v1::Case& c, double start) {
  std::vector<double> events{0.0};
  if (!c.mechanics().has_enabled() || c.mechanics().enabled())
    events.push_back(c.mechanics().start_s());
  const v1::Water& water = c.cooling().water();
  if (!water.has_enabled() || water.enabled()) events.push_back(water.start_s());

  std::erase_if(events, [&](double e) { return !(e >= start) || !(e < c.time().end_s()); });
  std::sort(events.begin(), events.end());
  events.erase(std::unique(events.begin(), events.end()), events.end());
  return events;
}

/// The table of time steps.
v1::Curve make_steps(const Discretisation& d, const v1::Case& c) {
  const double start = -c.schedule().hold_s(), end = c.time().end_s();
  v1::Curve curve;

  // Nothing to simulate: any valid table, so that only the check of the times reports a fault.
  if (!(end > start)) {
    curve.add_at(0.0);
    curve.add_value(1.0);
    return curve;
  }

  curve.set_abscissa(v1::TIME);
  std::vector<double> events = sudden_events(c, start);
  events.push_back(end);

  if (events.front() > start) add_steps(start, d.begin, events.front(), curve);
  for (std::size_t i = 0; i + 1 < events.size(); ++i)
    add_steps(events[i], d.event, events[i + 1], curve);
  return curve;
}

/// Whether elements, mesh and steps are those of the quality.
bool has_quality_mesh(const v1::Case& complete) {
  const v1::Mesh& mesh = complete.mesh();
  if (mesh.element() != v1::Q1_BENDING || mesh.refinement() != 1 || !mesh.file().empty() ||
      !complete.thermal().file().empty())
    return false;

  // Fill them once more and compare.
  v1::Case refilled = complete;
  for (const char* key : {"columns", "rows", "layers", "side_cell_m", "wide_side_cell_m",
                          "bottom_cell_m", "growth_cell_m", "merge_below_m", "merged_cell_m",
                          "heat_cells_per_column", "heat_cells_per_layer"})
    refilled.mesh().GetReflection()->ClearField(refilled.mutable_mesh(),
                                                v1::Mesh::descriptor()->FindFieldByName(key));
  refilled.mutable_time()->clear_step_s();
  apply_quality(refilled);
  return MessageDifferencer::Equals(refilled, complete);
}

/// Whether the bands were measured for such a casting: a section through the thickness of a slab,
/// or the start of a quarter slab, on a flat block without holes; not for what has cooled down.
bool is_measured_casting(const v1::Case& c) {
  if (c.time().cool_down_s() > 0.0) return false;
  const v1::BottomBlock& block = c.cooling().bottom_block();
  if (block.has_bowl() || block.drain_hole_size() > 0) return false;

  const double half_width = c.section().half_width_m();
  if (c.section().kind() == v1::Section::PLANE_STRAIN)
    return half_width >= 0.2 && half_width <= 0.4;
  if (c.section().kind() != v1::Section::QUARTER_SLAB) return false;

  const auto& half_thickness = c.section().half_thickness_m().value();
  return half_width >= 0.5 && half_width <= 1.1 && !half_thickness.empty() &&
         half_thickness[0] >= 0.2 && half_thickness[0] <= 0.4 && c.time().end_s() <= 1200.0;
}

}  // namespace

void apply_quality(v1::Case& c) {
  const Discretisation& d = choose_discretisation(c);
  v1::Mesh& mesh = *c.mutable_mesh();
  const bool own_rows = mesh.has_growth_cell_m() || mesh.has_rows();
  const bool own_plan = mesh.has_columns() || mesh.has_layers();

  if (c.section().half_width_m() > 0.0) fill_columns(d, c.section().half_width_m(), mesh);
  if (c.section().initial_depth_m() > 0.0) fill_rows(d, c.section().initial_depth_m(), mesh);
  if (c.section().kind() == v1::Section::QUARTER_SLAB) {
    fill_heat_cells(d, own_plan, mesh);
    if (c.section().half_thickness_m().value_size() > 0)
      fill_layers(d, c.section().half_thickness_m(), mesh);
    if (has_rows(c)) fill_merging(d, own_rows, mesh);
  }

  if (c.time().step_s().value_size() == 0) *c.mutable_time()->mutable_step_s() = make_steps(d, c);
}

std::optional<v1::RelativeError> relative_discretisation_error(const v1::Case& complete) {
  if (!is_measured_casting(complete) || !has_quality_mesh(complete)) return std::nullopt;
  const Band& band = choose_discretisation(complete).error;

  v1::RelativeError error;
  error.set_lower(band.below);
  error.set_upper(band.above);
  return error;
}

std::vector<FigureBand> figure_bands(const v1::Case& complete) {
  if (complete.section().kind() != v1::Section::QUARTER_SLAB || !is_measured_casting(complete) ||
      !has_quality_mesh(complete))
    return {};

  std::vector<FigureBand> bands;
  for (const MeasuredFigure& row : measured_figures) {
    const Band& band = complete.quality() == v1::DRAFT ? row.draft : row.finer;
    bands.push_back({row.figure, band.below, band.above, row.is_relative});
  }
  if (const std::string& monitor = complete.output().curl();
      !monitor.empty() && is_measured_at(complete, monitor)) {
    const Band& band = choose_discretisation(complete).error;
    bands.push_back({"curl", band.below, band.above, true});
  }
  return bands;
}

bool is_measured_at(const v1::Case& c, const std::string& name) {
  constexpr double same_place = 1e-6;  // [m]
  if (c.section().kind() != v1::Section::QUARTER_SLAB) return true;

  const auto find = [&](const std::string& wanted) {
    return std::ranges::find(c.monitor(), wanted, &v1::Monitor::name);
  };
  const auto is_on_the_edge = [&](const std::string& point) {
    const auto found = find(point);
    return found != c.monitor().end() && found->of().empty() &&
           std::abs(found->x_m() - c.section().half_width_m()) < same_place &&
           std::abs(found->z_m()) < same_place;
  };

  const auto monitor = find(name);
  if (monitor == c.monitor().end() || monitor->of().empty()) return is_on_the_edge(name);
  return std::ranges::all_of(monitor->of(), is_on_the_edge, &v1::MonitorShare::monitor);
}

std::optional<v1::RelativeError> monitor_error(const v1::Case& complete,
                                               const std::string& monitor) {
  if (!is_measured_at(complete, monitor)) return std::nullopt;
  return relative_discretisation_error(complete);
}

CurlError curl_error(const v1::RelativeError& error, double curl_m) {
  const double size_m = std::abs(curl_m);
  const CurlError above{.lower_m = error.lower() * size_m, .upper_m = error.upper() * size_m};
  if (curl_m >= 0.0) return above;
  return {.lower_m = above.upper_m, .upper_m = above.lower_m};
}

void add_curl(const std::optional<v1::RelativeError>& mesh_error, v1::MonitorValue& monitor) {
  const auto& displacement = monitor.displacement_m();
  if (displacement.size() < 2 || !std::isfinite(*displacement.rbegin())) return;
  monitor.set_curl_m(*displacement.rbegin());

  if (!mesh_error) return;
  const CurlError error = curl_error(*mesh_error, monitor.curl_m());
  monitor.set_curl_lower_error_m(error.lower_m);
  monitor.set_curl_upper_error_m(error.upper_m);
}

std::optional<PairedError> paired_error(const v1::Case& a, const v1::Case& b) {
  const v1::Section::Kind kind = a.section().kind();
  if (a.quality() != b.quality() || kind != b.section().kind() || !has_quality_mesh(a) ||
      !has_quality_mesh(b))
    return std::nullopt;

  if (kind == v1::Section::QUARTER_SLAB) return quarter_slab_pairs;
  if (is_measured_casting(a) && is_measured_casting(b))
    return PairedError{.of_curl = 0.005, .of_difference = 0.02};
  return std::nullopt;
}

bool quality_matters(const v1::Case& description) {
  v1::Case draft = description, fine = description;
  draft.set_quality(v1::DRAFT);
  fine.set_quality(v1::FINE);
  apply_defaults(draft);
  apply_defaults(fine);
  fine.set_quality(v1::DRAFT);
  return !MessageDifferencer::Equals(draft, fine);
}

v1::Case divided(const v1::Case& description, int parts) {
  v1::Case fine = description;
  apply_quality(fine);
  apply_defaults(*fine.mutable_mesh());
  apply_defaults(*fine.mutable_time());

  fine.mutable_mesh()->set_refinement(fine.mesh().refinement() * parts);
  v1::TimeControl& time = *fine.mutable_time();
  for (double& step : *time.mutable_step_s()->mutable_value()) step *= 1.0 / parts;
  time.set_minimum_step_s(time.minimum_step_s() * (1.0 / parts));
  return fine;
}

std::string reason_against_dividing(const v1::Case& description) {
  if (!has_rows(description))
    return "mesh.file: the cells of a mesh file cannot be divided here; make finer files and "
           "compare "
           "their runs, or use the built-in mesh";
  if (!description.thermal().file().empty())
    return "thermal.file: temperatures from a file belong to its nodes and do not become more "
           "exact "
           "on finer meshes; use the heat solver";
  if (description.monitor().empty() ||
      (description.mechanics().has_enabled() && !description.mechanics().enabled()))
    return "the case computes no curl: it needs a [[monitor]] and mechanics.enabled";
  return {};
}

}  // namespace dccast::case_file
