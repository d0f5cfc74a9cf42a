#include "client/model/field_probe.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace dccast::client {
namespace {

constexpr std::size_t most_nodes = 8;
constexpr double margin = 1e-6;  // [1] of the reference element: points on a face belong to it

using Coordinates = std::array<double, 3>;
using Shape = std::array<double, most_nodes>;  ///< of each node of an element [1]

/// Corners of the reference square and cube, in the order of the frame's elements (VTK).
constexpr std::array<Coordinates, most_nodes> corners{{{-1, -1, -1},
                                                       {1, -1, -1},
                                                       {1, 1, -1},
                                                       {-1, 1, -1},
                                                       {-1, -1, 1},
                                                       {1, -1, 1},
                                                       {1, 1, 1},
                                                       {-1, 1, 1}}};

double determinant(const std::array<Coordinates, 3>& m) {
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
         m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/// Solves m x = b by Cramer's rule. @return empty for a singular matrix
std::optional<Coordinates> solve(const std::array<Coordinates, 3>& m, const Coordinates& b) {
  const double whole = determinant(m);
  if (whole == 0.0 || !std::isfinite(whole)) return std::nullopt;

  Coordinates x{};
  for (std::size_t column = 0; column < 3; ++column) {
    std::array<Coordinates, 3> replaced = m;
    for (std::size_t row = 0; row < 3; ++row) replaced[row][column] = b[row];
    x[column] = determinant(replaced) / whole;
  }
  return x;
}

/// An element of a frame: in two dimensions it lies in the plane of the first two coordinates.
class Element {
public:
  Element(const v1::Frame& frame, int number)
      : dimension_(std::size_t(frame.dimension())), nodes_(std::size_t(frame.nodes_per_element())) {
    for (std::size_t i = 0; i < nodes_; ++i) {
      node_[i] = frame.element_node(number * frame.nodes_per_element() + int(i));
      for (std::size_t axis = 0; axis < dimension_; ++axis)
        place_[i][axis] = frame.node_m(node_[i] * frame.dimension() + int(axis));
    }
  }

  int node(std::size_t i) const { return node_[i]; }
  std::size_t nodes() const { return nodes_; }

  /// The shape functions at a point; empty outside of the element.
  std::optional<Shape> shape_at(const Coordinates& point) const {
    if (!box_holds(point)) return std::nullopt;
    return is_simplex() ? shape_of_simplex(point) : shape_of_brick(point);
  }

private:
  bool is_simplex() const { return nodes_ == dimension_ + 1; }

  bool box_holds(const Coordinates& point) const {
    for (std::size_t axis = 0; axis < dimension_; ++axis) {
      double low = place_[0][axis], high = low;
      for (std::size_t i = 1; i < nodes_; ++i) {
        low = std::min(low, place_[i][axis]);
        high = std::max(high, place_[i][axis]);
      }
      const double slack = margin * (high - low);
      if (point[axis] < low - slack || point[axis] > high + slack) return false;
    }
    return true;
  }

  std::optional<Shape> shape_of_simplex(const Coordinates& point) const {
    std::array<Coordinates, 3> edges{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    Coordinates from_first{};
    for (std::size_t axis = 0; axis < dimension_; ++axis) {
      from_first[axis] = point[axis] - place_[0][axis];
      for (std::size_t i = 0; i < dimension_; ++i)
        edges[axis][i] = place_[i + 1][axis] - place_[0][axis];
    }
    const auto parts = solve(edges, from_first);
    if (!parts) return std::nullopt;

    Shape shape{1.0};
    for (std::size_t i = 0; i < dimension_; ++i) {
      shape[i + 1] = (*parts)[i];
      shape[0] -= (*parts)[i];
    }
    for (std::size_t i = 0; i < nodes_; ++i)
      if (shape[i] < -margin) return std::nullopt;
    return shape;
  }

  /// Bilinear or trilinear, at coordinates of the reference element.
  Shape shape_of_reference(const Coordinates& at) const {
    Shape shape{};
    for (std::size_t i = 0; i < nodes_; ++i) {
      shape[i] = 1.0;
      for (std::size_t axis = 0; axis < dimension_; ++axis)
        shape[i] *= 0.5 * (1.0 + corners[i][axis] * at[axis]);
    }
    return shape;
  }

  /// Derivatives of the place by the coordinates of the reference element.
  std::array<Coordinates, 3> jacobian(const Coordinates& at) const {
    std::array<Coordinates, 3> j{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    for (std::size_t row = 0; row < dimension_; ++row)
      for (std::size_t by = 0; by < dimension_; ++by) {
        j[row][by] = 0.0;
        for (std::size_t i = 0; i < nodes_; ++i) {
          double slope = 0.5 * corners[i][by];
          for (std::size_t axis = 0; axis < dimension_; ++axis)
            if (axis != by) slope *= 0.5 * (1.0 + corners[i][axis] * at[axis]);
          j[row][by] += slope * place_[i][row];
        }
      }
    return j;
  }

  /// Newton's method for the reference coordinates of the point.
  std::optional<Shape> shape_of_brick(const Coordinates& point) const {
    constexpr int most_iterations = 20;
    constexpr double converged = 1e-10;
    Coordinates at{};
    for (int iteration = 0; iteration < most_iterations; ++iteration) {
      const Shape shape = shape_of_reference(at);
      Coordinates off{};
      for (std::size_t axis = 0; axis < dimension_; ++axis) {
        off[axis] = point[axis];
        for (std::size_t i = 0; i < nodes_; ++i) off[axis] -= shape[i] * place_[i][axis];
      }
      const auto step = solve(jacobian(at), off);
      if (!step) return std::nullopt;

      double largest = 0.0;
      for (std::size_t axis = 0; axis < dimension_; ++axis) {
        at[axis] += (*step)[axis];
        largest = std::max(largest, std::abs((*step)[axis]));
      }
      if (largest > converged) continue;
      for (std::size_t axis = 0; axis < dimension_; ++axis)
        if (std::abs(at[axis]) > 1.0 + margin) return std::nullopt;
      return shape_of_reference(at);
    }
    return std::nullopt;
  }

  std::size_t dimension_, nodes_;
  std::array<int, most_nodes> node_{};
  std::array<Coordinates, most_nodes> place_{};
};

bool is_sound(const v1::Frame& frame) {
  const int dimension = frame.dimension(), nodes = frame.temperature_c_size();
  const int per_element = frame.nodes_per_element();
  const bool known = (dimension == 2 && (per_element == 3 || per_element == 4)) ||
                     (dimension == 3 && (per_element == 4 || per_element == 8));
  return known && frame.node_m_size() == nodes * dimension &&
         frame.element_node_size() % per_element == 0 &&
         (frame.displacement_m().empty() || frame.displacement_m_size() == nodes * dimension) &&
         std::ranges::all_of(frame.element_node(),
                             [&](int node) { return node >= 0 && node < nodes; });
}

PointValues interpolated(const v1::Frame& frame, const Element& element, const Shape& shape) {
  const int dimension = frame.dimension();
  PointValues values;
  if (!frame.displacement_m().empty()) values.displacement_m.assign(std::size_t(dimension), 0.0);
  for (std::size_t i = 0; i < element.nodes(); ++i) {
    values.temperature_c += shape[i] * frame.temperature_c(element.node(i));
    for (std::size_t axis = 0; axis < values.displacement_m.size(); ++axis)
      values.displacement_m[axis] +=
          shape[i] * frame.displacement_m(element.node(i) * dimension + int(axis));
  }
  return values;
}

}  // namespace

std::optional<PointValues> values_at(const v1::Frame& frame, const std::vector<double>& point) {
  if (!is_sound(frame) || point.size() != std::size_t(frame.dimension())) return std::nullopt;
  Coordinates place{};
  std::ranges::copy(point, place.begin());

  const int elements = frame.element_node_size() / frame.nodes_per_element();
  for (int number = 0; number < elements; ++number) {
    const Element element(frame, number);
    if (const auto shape = element.shape_at(place)) return interpolated(frame, element, *shape);
  }
  return std::nullopt;
}

std::vector<std::vector<double>> points_on_line(const std::vector<double>& from,
                                                const std::vector<double>& to, int count) {
  std::vector<std::vector<double>> points;
  for (int i = 0; i < count; ++i) {
    const double share = double(i) / (count - 1);
    std::vector<double>& point = points.emplace_back(from);
    for (std::size_t axis = 0; axis < point.size(); ++axis)
      point[axis] = (1.0 - share) * from[axis] + share * to[axis];
  }
  return points;
}

}  // namespace dccast::client
