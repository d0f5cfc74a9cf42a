#pragma once

#include <vector>

#include "core/mesh/mesh.hpp"
#include "core/thermal/cooling_spec.hpp"

namespace dccast::thermal {

/// The part of a boundary that one node stands for under one cooling law.
struct SideShare {
  int node = 0;
  int law = 0;            ///< zone's number, or `law_water`, `law_dry`
  double weight = 0.0;    ///< integral of the node's shape function [m]; axisymmetric: times r [m2]
  double distance = 0.0;  ///< [m] below the metal level where the law is evaluated
};
inline constexpr int law_water = -1;
inline constexpr int law_dry = -2;

/// Divides the side among nodes and laws for one position of the metal level.
///
/// Facets are cut at every zone edge, at the water line and where a table against distance has a
/// kink, and the shape functions integrated exactly over the pieces, so that the result is a
/// continuous function of every edge. Below the water line water comes first, if it runs; else the
/// first zone that covers the piece; else the side is dry. In an axisymmetric section everything is
/// weighted by the radius and 2 pi is left out.
///
/// @param shares  replaced; its storage is kept from step to step
void divide_side(const CoolingSpec& cooling, const mesh::Mesh2D& mesh, mesh::SectionKind kind,
                 double metal_level, bool water_runs, std::vector<SideShare>& shares);

/// Integral of the shape function of each node of the bottom, in the order of
/// `mesh::patch_nodes(mesh, PatchKind::bottom)` [m]; axisymmetric: times r [m2], 2 pi left out.
std::vector<double> bottom_weights(const mesh::Mesh2D& mesh, mesh::SectionKind kind,
                                   const std::vector<int>& bottom_nodes);

}  // namespace dccast::thermal
