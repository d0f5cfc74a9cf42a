#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/thermal/cooling_spec.hpp"

namespace dccast::thermal {

/// The part of a boundary that one node stands for under one cooling law.
///
/// Facets are cut at every zone edge, at the water line and where a table against distance has a
/// kink, and the shape functions integrated exactly over the pieces, so that the result is a
/// continuous function of every edge. Below the water line water comes first, if it runs; else the
/// first zone of the face that covers the piece; else the side is dry. In an axisymmetric section
/// everything is weighted by the radius and 2 pi is left out.
///
/// The faces of a solid overlap at a corner only in its nodes: each facet is cooled as its own face
/// is, and a node of the edge has shares of both. No area counts twice and none is left out.
struct SideShare {
  int node = 0;
  int law = 0;  ///< zone's number, or `law_water`, `law_dry`
  /// Integral of the node's shape function [m]; axisymmetric: times r [m2]; solid: [m2].
  double weight = 0.0;
  double distance = 0.0;  ///< [m] below the metal level where the law is evaluated
  Face face = Face::wide;
};
inline constexpr int law_water = -1;
inline constexpr int law_dry = -2;

/// What decides at one instant which law holds where.
struct SideInstant {
  double metal_level = 0.0;              ///< [m]
  std::array<bool, faces> water_runs{};  ///< by face
  /// (node) [m] by which the side stands higher than in the mesh; empty: as in the mesh.
  std::span<const double> rise;
};

/// The law of a place.
struct LawAt {
  int number = law_dry;
  bool by_distance = false;  ///< it is a table against distance
};

/// The laws of the side at one instant.
class SideLaws {
public:
  SideLaws(const CoolingSpec& cooling, const SideInstant& instant);
  /// Every distance below the metal level at which a law may change or has a kink [m], rising.
  const std::vector<double>& edges() const { return edges_; }
  /// @param distance  [m] below the metal level
  LawAt at(double distance, Face face) const;

private:
  const CoolingSpec& cooling_;
  std::array<bool, faces> water_runs_;
  std::vector<double> edges_;
};

}  // namespace dccast::thermal
