#pragma once

#include <array>
#include <vector>

namespace dccast::client::render {

/// A point of a section or of a drawing.
struct Point {
  double x = 0.0;  ///< [m], in a drawing [view box unit]
  double y = 0.0;  ///< [m], in a drawing [view box unit]
};

using Segment = std::array<Point, 2>;

/// Triangles of a mesh of triangles or quadrilaterals (each cut along its first diagonal).
/// @param element_node      (element, nodes_per_element), nodes of an element in order around it
/// @return                  node numbers, three per triangle; empty for other kinds of elements
std::vector<std::array<int, 3>> triangles_of(const std::vector<int>& element_node,
                                             int nodes_per_element);

/// Contour line at the value `level` [unit of `value`] of a field that is linear in each triangle,
/// by marching triangles. Corners exactly on the level count as above it, so that no piece appears
/// twice.
std::vector<Segment> isotherm(const std::vector<Point>& node, const std::vector<double>& value,
                              const std::vector<std::array<int, 3>>& triangles, double level);

}  // namespace dccast::client::render
