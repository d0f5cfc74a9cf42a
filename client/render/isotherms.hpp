#pragma once

#include <array>
#include <vector>

namespace dccast::client::render {

struct Point {
  double x = 0.0;
  double y = 0.0;
};

using Segment = std::array<Point, 2>;

/// Triangles of a mesh of triangles or quadrilaterals (each cut along its first diagonal).
/// @param element_node      (element, nodes_per_element), nodes of an element in order around it
/// @return                  node numbers, three a triangle; elements of another kind give none
std::vector<std::array<int, 3>> triangles_of(const std::vector<int>& element_node,
                                             int nodes_per_element);

/// Line on which a field that is linear in each triangle has the value `level`: marching triangles.
/// Corners that lie exactly on the level count as above it, so that no piece appears twice.
std::vector<Segment> isotherm(const std::vector<Point>& node, const std::vector<double>& value,
                              const std::vector<std::array<int, 3>>& triangles, double level);

}  // namespace dccast::client::render
