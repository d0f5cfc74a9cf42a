#include "proto/frames/steady_face.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace dccast::frames {
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
