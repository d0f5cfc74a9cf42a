#include "proto/frames/contraction.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <sstream>
#include <utility>

namespace dccast::frames {

double curve_value(const v1::Curve& curve, double at) {
  const int count = std::min(curve.at_size(), curve.value_size());
  const auto begin = curve.at().begin();
  const auto right = static_cast<int>(std::lower_bound(begin, begin + count, at) - begin);
  if (right == 0) return curve.value(0);
  if (right == count) return curve.value(count - 1);
  const double share = (at - curve.at(right - 1)) / (curve.at(right) - curve.at(right - 1));
  return curve.value(right - 1) + share * (curve.value(right) - curve.value(right - 1));
}

double curve_value(const v1::Curve& curve, double time_s, double cast_length_m, double otherwise) {
  if (curve.value().empty()) return otherwise;
  return curve_value(curve, curve.abscissa() == v1::CAST_LENGTH ? cast_length_m : time_s);
}

namespace {

constexpr double room_temperature_c = 20.0;
constexpr double same_place_m = 1e-7;

/// The nodes at one x and one height, as y and number, from the middle plane outwards.
using Line = std::vector<std::pair<double, int>>;
/// By height and by x, both in steps of `same_place_m`.
using Lines = std::map<std::int64_t, std::map<std::int64_t, Line>>;

std::int64_t place(double metres) {
  return std::llround(metres / same_place_m);
}

Lines lines_of(const v1::Frame& frame) {
  Lines lines;
  for (int n = 0; 3 * n + 2 < frame.node_m_size(); ++n)
    lines[place(frame.node_m(3 * n + 2))][place(frame.node_m(3 * n))].emplace_back(
        frame.node_m(3 * n + 1), n);
  for (auto& [height, row] : lines)
    for (auto& [x, line] : row) std::sort(line.begin(), line.end());
  return lines;
}

class FaceReading {
public:
  FaceReading(const v1::Case& solved, const v1::Frame& frame)
      : alloy_(solved.alloy()), opening_(solved.section().half_thickness_m()), frame_(frame) {}

  Contraction all() const {
    Contraction contraction{frame_.time_s(), frame_.cast_length_m(), {}};
    for (const auto& [height, lines] : lines_of(frame_)) {
      FaceRow row = row_of(lines);
      if (row.points.size() < 2) continue;
      row.height_m = static_cast<double>(height) * same_place_m;
      contraction.rows.push_back(std::move(row));
    }
    return contraction;
  }

private:
  FaceRow row_of(const std::map<std::int64_t, Line>& lines) const {
    FaceRow row;
    for (const auto& [x, line] : lines) {
      const FacePoint point = point_of(static_cast<double>(x) * same_place_m, line);
      if (!crosses(point, line)) continue;
      row.points.push_back(point);
      row.solid = row.solid && std::isfinite(point.cold_m);
    }
    return row;
  }

  /// Whether a line leads all the way from the middle plane to the face. Those of a mesh from a
  /// file may not.
  static bool crosses(const FacePoint& point, const Line& line) {
    constexpr double tolerance_m = 1e-6;
    return line.size() > 1 && std::abs(line.front().first) < tolerance_m &&
           std::abs(line.back().first - point.mould_m) < tolerance_m;
  }

  FacePoint point_of(double x_m, const Line& line) const {
    FacePoint point{x_m, curve_value(opening_, x_m), 0.0, 0.0};
    point.now_m = line.back().first + frame_.displacement_m(3 * line.back().second + 1);
    point.cold_m = point.now_m + strain_to_come(line);
    return point;
  }

  /// Integral of the free strain from the present temperature to 20 °C along a line [m].
  double strain_to_come(const Line& line) const {
    double sum_m = 0.0;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const double temperature_c = frame_.temperature_c(line[i].second);
      if (temperature_c > shell_c(frame_)) return std::numeric_limits<double>::quiet_NaN();
      const double from = i == 0 ? line[i].first : line[i - 1].first;
      const double to = i + 1 == line.size() ? line[i].first : line[i + 1].first;
      sum_m += 0.5 * (to - from) * (stretch(room_temperature_c) - stretch(temperature_c));
    }
    return sum_m;
  }

  /// Length over that at the liquidus, as the mechanics takes it (paper eq. (11)).
  double stretch(double temperature_c) const {
    return std::cbrt(density(frame_.liquidus_c()) / density(temperature_c));
  }

  /// [kg/m3], of a card with the densities of solid and liquid weighted by their fractions.
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

}  // namespace

double shell_c(const v1::Frame& frame) {
  return frame.shell_c() > 0.0 ? frame.shell_c() : frame.solidus_c();
}

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
        "contraction across the thickness is that of a job with section.kind = "
        "\"quarter_slab\"; this one is not");
  if (frame.displacement_m_size() != frame.node_m_size() ||
      3 * frame.temperature_c_size() != frame.node_m_size())
    throw NoContraction("the last frame has no displacements: run the case with mechanics");
  Contraction contraction = FaceReading(solved, frame).all();
  if (contraction.rows.empty())
    throw NoContraction(
        "no line of nodes leads straight from the middle plane to the wide face: "
        "run the case on the built-in mesh, without mesh.file");
  return contraction;
}

// Away from butt and head.

namespace {

constexpr double read_at = 0.9;       // of the solid height
constexpr double steady_from = 0.75;  // of the solid height
// The butt pulls in like a plate up to about its half-thickness (docs/contraction.md, heights 47 to
// 416 mm of a slab of 285 mm).
constexpr double butt_in_half_thicknesses = 1.0;

std::string in_mm(double metres) {
  std::ostringstream text;
  text.precision(3);
  text << 1e3 * metres << " mm";
  return text.str();
}

/// Most that two rows differ by, at the points that both have.
double difference(const FaceRow& a, const FaceRow& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < std::min(a.points.size(), b.points.size()); ++i)
    most = std::max(most, std::abs(a.points[i].cold_m - b.points[i].cold_m));
  return most;
}

void require_solid(const Contraction& contraction, const FaceRow& head) {
  const double needed_m =
      butt_in_half_thicknesses * contraction.rows.front().points.front().mould_m / read_at;
  const double solid_m = head.solid ? head.height_m : 0.0;
  if (solid_m >= needed_m) return;
  throw NoContraction("the slab is solid all through up to " + in_mm(solid_m) +
                      " only, at a cast length of " + in_mm(contraction.cast_length_m) +
                      "; away from its butt begins at " + in_mm(needed_m) +
                      ": cast longer, with a later time.end");
}

}  // namespace

double SteadyFace::residual_m(double wanted_m) const {
  double most = 0.0;
  for (const double cold : cold_m) most = std::max(most, std::abs(cold - wanted_m));
  return most;
}

SteadyFace steady_face(const Contraction& contraction) {
  const FaceRow& head = contraction.head();
  require_solid(contraction, head);
  const FaceRow& row = contraction.at(read_at * head.height_m);
  SteadyFace face;
  face.height_m = row.height_m;
  for (const FaceRow& other : contraction.rows)
    if (other.solid && other.height_m >= steady_from * head.height_m)
      face.change_m = std::max(face.change_m, difference(row, other));
  for (const FacePoint& point : row.points) {
    face.x_m.push_back(point.x_m);
    face.mould_m.push_back(point.mould_m);
    face.cold_m.push_back(point.cold_m);
  }
  return face;
}

}  // namespace dccast::frames
