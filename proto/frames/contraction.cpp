#include "proto/frames/contraction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <utility>

#include "proto/case_file/schedule.hpp"

namespace dccast::frames {

using case_file::curve_value;

namespace {

constexpr double room_temperature_c = 20.0;
constexpr double same_place_m = 1e-7;

constexpr double evaluated_share = 0.9;  // of the solid height: where the steady face is evaluated
constexpr double steady_share = 0.75;    // of the solid height: from there the casting is steady
/// Height of the butt, in half-thicknesses: up to there it pulls in like a plate
/// (docs/contraction.md, heights 47 to 416 mm of a slab of 285 mm).
constexpr double butt_in_half_thicknesses = 1.0;

/// The nodes at one x and one height, as y [m] and number, from the middle plane outwards.
using Line = std::vector<std::pair<double, int>>;
/// By height and by x, both in multiples of `same_place_m`.
using Lines = std::map<std::int64_t, std::map<std::int64_t, Line>>;

std::int64_t quantize(double metres) {
  return std::llround(metres / same_place_m);
}

Lines collect_lines(const v1::Frame& frame) {
  Lines lines;
  for (int n = 0; 3 * n + 2 < frame.node_m_size(); ++n)
    lines[quantize(frame.node_m(3 * n + 2))][quantize(frame.node_m(3 * n))].emplace_back(
        frame.node_m(3 * n + 1), n);
  for (auto& [height, row] : lines)
    for (auto& [x, line] : row) std::sort(line.begin(), line.end());
  return lines;
}

/// Evaluates the lines of nodes of a frame.
class FaceReading {
public:
  FaceReading(const v1::Case& solved, const v1::Frame& frame)
      : alloy_(solved.alloy()), opening_(solved.section().half_thickness_m()), frame_(frame) {}

  Contraction read_rows() const {
    Contraction contraction{frame_.time_s(), frame_.cast_length_m(), {}};
    for (const auto& [height, lines] : collect_lines(frame_)) {
      FaceRow row = read_row(lines);
      if (row.points.size() < 2) continue;

      row.height_m = static_cast<double>(height) * same_place_m;
      contraction.rows.push_back(std::move(row));
    }
    return contraction;
  }

private:
  FaceRow read_row(const std::map<std::int64_t, Line>& lines) const {
    FaceRow row;
    for (const auto& [x, line] : lines) {
      const FacePoint point = read_point(static_cast<double>(x) * same_place_m, line);
      if (!crosses(point, line)) continue;
      row.points.push_back(point);
      row.solid = row.solid && std::isfinite(point.cold_m);
    }
    return row;
  }

  /// Whether a line extends from the middle plane to the face; in a mesh from a file it may not.
  static bool crosses(const FacePoint& point, const Line& line) {
    constexpr double tolerance_m = 1e-6;
    return line.size() > 1 && std::abs(line.front().first) < tolerance_m &&
           std::abs(line.back().first - point.mould_m) < tolerance_m;
  }

  FacePoint read_point(double x_m, const Line& line) const {
    FacePoint point{x_m, curve_value(opening_, x_m), 0.0, 0.0};
    point.now_m = line.back().first + frame_.displacement_m(3 * line.back().second + 1);
    point.cold_m = point.now_m + remaining_contraction(line);
    return point;
  }

  /// Integral of the free strain from the present temperature to 20 °C along a line [m].
  double remaining_contraction(const Line& line) const {
    double sum_m = 0.0;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const double temperature_c = frame_.temperature_c(line[i].second);
      if (temperature_c > frame_.shell_c()) return std::numeric_limits<double>::quiet_NaN();

      // Trapezoidal rule: each node has half of the pieces on both of its sides.
      const double from = i == 0 ? line[i].first : line[i - 1].first;
      const double to = i + 1 == line.size() ? line[i].first : line[i + 1].first;
      sum_m += 0.5 * (to - from) * (stretch(room_temperature_c) - stretch(temperature_c));
    }
    return sum_m;
  }

  /// Length relative to that at the liquidus, as in the mechanics (paper eq. (11)) [1].
  double stretch(double temperature_c) const {
    return std::cbrt(density(frame_.liquidus_c()) / density(temperature_c));
  }

  /// Density [kg/m3]; if the card has those of solid and liquid, weighted by their fractions.
  double density(double temperature_c) const {
    if (alloy_.has_density_kg_per_m3())
      return curve_value(alloy_.density_kg_per_m3(), temperature_c);
    const double liquid = liquid_fraction(temperature_c);
    return (1.0 - liquid) * curve_value(alloy_.solid_density_kg_per_m3(), temperature_c) +
           liquid * alloy_.liquid_density_kg_per_m3();
  }

  double liquid_fraction(double temperature_c) const {
    if (temperature_c >= alloy_.liquidus_c()) return 1.0;
    if (alloy_.has_liquid_fraction()) return curve_value(alloy_.liquid_fraction(), temperature_c);
    if (temperature_c <= alloy_.solidus_c()) return 0.0;
    return (temperature_c - alloy_.solidus_c()) / (alloy_.liquidus_c() - alloy_.solidus_c());
  }

  const v1::Alloy& alloy_;
  const v1::Curve& opening_;
  const v1::Frame& frame_;
};

std::string format_mm(double metres) {
  return fmt::format("{:.3g} mm", 1e3 * metres);
}

/// Largest difference of cold half-thickness between two rows [m], at the points that both have.
double largest_difference(const FaceRow& a, const FaceRow& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < std::min(a.points.size(), b.points.size()); ++i)
    largest = std::max(largest, std::abs(a.points[i].cold_m - b.points[i].cold_m));
  return largest;
}

/// @throws NoContraction  the solid part ends before the casting is steady
void require_steady_part(const Contraction& contraction, const FaceRow& head) {
  const double needed_m =
      butt_in_half_thicknesses * contraction.rows.front().points.front().mould_m / evaluated_share;
  const double solid_m = head.solid ? head.height_m : 0.0;
  if (solid_m >= needed_m) return;

  throw NoContraction(fmt::format(
      "the slab is completely solid only up to {}, at a cast length of {}; the part away from its "
      "butt begins at {}: cast longer, with a later time.end",
      format_mm(solid_m), format_mm(contraction.cast_length_m), format_mm(needed_m)));
}

}  // namespace

double half_opening_m(const v1::Section& section, double x_m) {
  return curve_value(section.half_thickness_m(), x_m);
}

const FaceRow& Contraction::at(double height_m) const {
  const auto distance = [&](const FaceRow& row) { return std::abs(row.height_m - height_m); };
  return *std::ranges::min_element(rows, {}, distance);
}

const FaceRow& Contraction::head() const {
  const auto solid = std::find_if(rows.rbegin(), rows.rend(), std::mem_fn(&FaceRow::solid));
  return solid == rows.rend() ? rows.back() : *solid;
}

Contraction contraction_of(const v1::Case& solved, const v1::Frame& frame) {
  if (frame.dimension() != 3 || solved.section().half_thickness_m().value_size() == 0)
    throw NoContraction(
        "contraction across the thickness needs a job with section.kind = \"quarter_slab\"; this "
        "one has another section");
  if (frame.displacement_m_size() != frame.node_m_size() ||
      3 * frame.temperature_c_size() != frame.node_m_size())
    throw NoContraction("the last frame has no displacements: run the case with mechanics");

  Contraction contraction = FaceReading(solved, frame).read_rows();
  if (contraction.rows.empty())
    throw NoContraction(
        "no line of nodes leads straight from the middle plane to the wide face: run the case on "
        "the built-in mesh, without mesh.file");
  return contraction;
}

double SteadyFace::residual_m(double wanted_m) const {
  double largest = 0.0;
  for (const double cold : cold_m) largest = std::max(largest, std::abs(cold - wanted_m));
  return largest;
}

SteadyFace steady_face(const Contraction& contraction) {
  const FaceRow& head = contraction.head();
  require_steady_part(contraction, head);
  const FaceRow& row = contraction.at(evaluated_share * head.height_m);

  SteadyFace face;
  face.height_m = row.height_m;
  for (const FaceRow& other : contraction.rows)
    if (other.solid && other.height_m >= steady_share * head.height_m)
      face.change_m = std::max(face.change_m, largest_difference(row, other));

  for (const FacePoint& point : row.points) {
    face.x_m.push_back(point.x_m);
    face.mould_m.push_back(point.mould_m);
    face.cold_m.push_back(point.cold_m);
  }
  return face;
}

}  // namespace dccast::frames
