#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/thermal/cooling_spec.hpp"

namespace dccast::thermal {

/// The part of the boundary that belongs to one node and one cooling law.
///
/// Facets are cut at every zone edge, at the water line and at the kinks of tables against
/// distance, and the shape functions are integrated exactly over the pieces, so that the result
/// depends continuously on every edge. Below the water line, running water takes precedence;
/// otherwise the first zone of the face that covers the piece applies; otherwise the side is dry.
/// In an axisymmetric section everything is weighted by the radius, without 2 pi.
///
/// At an edge of a solid the two faces share only nodes: each facet is cooled by the law of its own
/// face, and a node on the edge has shares of both. No area is counted twice or left out.
struct SideShare {
  int node = 0;
  int law = 0;  ///< index of the zone, or `law_water`, `law_dry`
  /// Integral of the node's shape function [m]; axisymmetric: times r [m2]; solid: [m2].
  double weight = 0.0;
  double distance = 0.0;  ///< [m] below the metal level where the law is evaluated
  Face face = Face::wide;
};
inline constexpr int law_water = -1;
inline constexpr int law_dry = -2;

/// Data that determine the cooling law of each place at one time.
struct SideInstant {
  double metal_level = 0.0;              ///< [m]
  std::array<bool, faces> water_runs{};  ///< by face
  /// (node) [m] vertical displacement of the side; empty: zero.
  std::span<const double> rise;
};

/// The cooling law of a place.
struct LawAt {
  int number = law_dry;
  bool by_distance = false;  ///< the law is a table against distance
};

/// The cooling laws of the side at one time.
class SideLaws {
public:
  SideLaws(const CoolingSpec& cooling, const SideInstant& instant);
  /// Distances below the metal level at which a law may change or has a kink [m], ascending.
  const std::vector<double>& edges() const { return edges_; }
  /// @param distance  [m] below the metal level
  LawAt at(double distance, Face face) const;

private:
  const CoolingSpec& cooling_;
  std::array<bool, faces> water_runs_;
  std::vector<double> edges_;  ///< [m]
};

}  // namespace dccast::thermal
