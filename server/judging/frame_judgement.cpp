// What the last stored frame of a run shows: the gap under the butt and the contraction of the wide
// face.
#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <tuple>

#include "proto/frames/contraction.hpp"
#include "server/judging/judgement.hpp"
#include "server/judging/run_judgement.hpp"

namespace dccast::judging {
namespace {

using frames::FacePoint, frames::FaceRow;

/// Place of a node of the bottom [m]; the frame of a worker is consistent.
double coordinate(const v1::Frame& frame, int node, int axis) {
  return frame.node_m(frame.dimension() * node + axis);
}

/// Gap and pressure along the bottom of a section.
void add_contact(const v1::Frame& frame, const std::string& mark, v1::Judgement& judgement) {
  constexpr const char* distance = "distance from the symmetry plane";
  std::vector<double> places;
  for (const int node : frame.bottom_node()) places.push_back(coordinate(frame, node, 0));

  // A run without mechanics has no pressure.
  v1::Chart& gap =
      add_chart(judgement, "bottom_gap", "gap along the bottom", {distance, "m", "gap", "m"});
  add_line(gap, "gap", places, {frame.bottom_gap_m().begin(), frame.bottom_gap_m().end()});
  gap.set_note(mark + "Distance between slab and bottom block at the last frame.");

  if (frame.bottom_pressure_pa_size() != frame.bottom_node_size()) return;
  v1::Chart& pressure = add_chart(judgement, "bottom_pressure", "contact pressure",
                                  {distance, "m", "pressure", "Pa"});
  add_line(pressure, "pressure", places,
           {frame.bottom_pressure_pa().begin(), frame.bottom_pressure_pa().end()});
  pressure.set_note(mark + "Zero where the slab has lifted off the block.");
}

/// The largest gap under a quarter slab, and how much of the bottom stands on the block.
void add_bottom(const v1::Frame& frame, const std::string& mark, v1::Judgement& judgement) {
  const auto largest = std::ranges::max_element(frame.bottom_gap_m());
  const int node = frame.bottom_node(int(largest - frame.bottom_gap_m().begin()));
  const auto contacts = std::ranges::count_if(frame.bottom_pressure_pa(),
                                              [](double pressure) { return pressure > 0.0; });

  v1::Table& table = add_table(judgement, "bottom", "gap under the butt", v1::JudgementPart::PAGE);
  add_columns(table, {
                         number_column("largest_gap", "largest gap", "m", 1e-5),
                         number_column("x", "at x", "m", 1e-3),
                         number_column("y", "at y", "m", 1e-3),
                         number_column("nodes_in_contact", "nodes on the block", "", 1.0),
                         number_column("nodes", "nodes of the bottom", "", 1.0),
                     });
  add_row(table, {number_cell(*largest), number_cell(coordinate(frame, node, 0)),
                  number_cell(coordinate(frame, node, 1)), number_cell(double(contacts)),
                  number_cell(frame.bottom_node_size())});
  table.set_note(mark + "The bottom seen from below; x and y from the middle of the slab.");
}

/// The highest row of the wide face that is solid with all rows below it. The metal behind the face
/// may be liquid there.
const FaceRow& highest_solid(const frames::Contraction& face, const v1::Section& section,
                             const v1::Frame& frame) {
  constexpr double same_m = 1e-6;
  double soft_m = std::numeric_limits<double>::infinity();
  for (int n = 0; n < frame.temperature_c_size(); ++n) {
    const double opening_m = frames::half_opening_m(section, coordinate(frame, n, 0));
    const bool on_face = coordinate(frame, n, 1) > opening_m - same_m;
    if (on_face && frame.temperature_c(n) > frame.shell_c())
      soft_m = std::min(soft_m, coordinate(frame, n, 2));
  }

  const FaceRow* highest = &face.rows.front();
  for (const FaceRow& row : face.rows)
    if (row.height_m < soft_m - same_m) highest = &row;
  return *highest;
}

struct NamedRow {
  std::string name;
  const FaceRow& row;
};

/// Head, and below it middle and butt.
std::vector<NamedRow> shown_rows(const frames::Contraction& face, const FaceRow& head) {
  const FaceRow& butt = face.at(std::min(frames::butt_height_m, head.height_m));
  std::vector<NamedRow> rows{{"head", head}};
  if (butt.height_m >= head.height_m) return rows;

  rows.push_back({"middle", face.at((butt.height_m + head.height_m) / 2.0)});
  rows.push_back({"butt", butt});
  return rows;
}

/// The figures of each row at the middle, half way and at the end of the wide face.
void add_pull_in_table(const std::vector<NamedRow>& rows, v1::Judgement& judgement) {
  v1::Table& table =
      add_table(judgement, "pull_in", "pull-in of the wide face", v1::JudgementPart::PAGE);
  add_columns(table, {text_column("place", "place")});
  for (const auto& [key, heading, resolution_m] : {std::tuple("height", "height", 1e-3),
                                                   {"x", "x", 1e-3},
                                                   {"mould", "mould", 1e-4},
                                                   {"slab", "slab", 1e-4},
                                                   {"pull_in", "pull-in", 1e-4}})
    add_columns(table, {number_column(key, heading, "m", resolution_m)});
  add_columns(table, {number_column("share", "share", "1", 1e-3)});

  for (const auto& [name, row] : rows) {
    const std::size_t last = row.points.size() - 1;
    for (const std::size_t i : {std::size_t{0}, last / 2, last}) {
      const FacePoint& point = row.points[i];
      add_row(table,
              {text_cell(name), number_cell(row.height_m), number_cell(point.x_m),
               number_cell(point.mould_m), number_cell(point.now_m), number_cell(point.pull_in_m()),
               number_cell(point.pull_in_m() / point.mould_m)});
    }
  }
}

void add_pull_in(const v1::Case& solved, const v1::Frame& frame, const std::string& mark,
                 v1::Judgement& judgement) try {
  const frames::Contraction face = frames::contraction_of(solved, frame);
  const FaceRow& head = highest_solid(face, solved.section(), frame);
  const std::vector<NamedRow> rows = shown_rows(face, head);

  v1::Chart& chart = add_chart(judgement, "pull_in", "pull-in of the wide face",
                               {"distance from the middle of the wide face", "m", "pull-in", "m"});
  for (const auto& [name, row] : rows) {
    std::vector<double> places, pull_in;
    for (const FacePoint& point : row.points) {
      places.push_back(point.x_m);
      pull_in.push_back(point.pull_in_m());
    }
    add_line(chart, fmt::format("{}, {:.0f} mm", name, 1e3 * row.height_m), places, pull_in);
  }
  chart.set_note(
      mark +
      "Half the opening of the mould minus half the thickness of the slab, in % of the former; "
      "negative values are a bulge. Butt: 50 mm above the block; head: the greatest height at "
      "which the whole face is solid; middle: half way. Heights in the undeformed slab.");
  add_pull_in_table(rows, judgement);
} catch (const frames::NoContraction&) {
  // A mesh without lines across the slab, or a run without mechanics: there is nothing to show.
}

}  // namespace

void add_frame(const v1::Case& solved, const v1::Frame& frame, bool is_beyond,
               v1::Judgement& judgement) {
  const std::string mark = is_beyond ? "Beyond validity. " : "";
  const bool has_bottom =
      frame.bottom_node_size() > 0 && frame.bottom_gap_m_size() == frame.bottom_node_size();
  if (has_bottom && frame.dimension() == 2) add_contact(frame, mark, judgement);
  if (has_bottom && frame.dimension() == 3) add_bottom(frame, mark, judgement);
  if (frame.dimension() == 3) add_pull_in(solved, frame, mark, judgement);
}

}  // namespace dccast::judging
