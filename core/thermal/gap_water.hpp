#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/thermal/heat_forms.hpp"
#include "core/thermal/water_film.hpp"

namespace dccast::thermal {

/// A bottom node at an opening of the gap to the air: a place of the edge, or a drain hole.
struct GapOpening {
  std::size_t node = 0;
  std::size_t opening = 0;  ///< number of the opening; a hole may have several nodes
  double distance = 0.0;    ///< [m] of the node from it
};

/// The shortest way through the open gap from an opening to a place.
struct GapRoute {
  std::size_t opening = 0;  ///< its number
  double distance = 0.0;    ///< [m]
};

/// The way to each place of the bottom from the nearest opening; none where the gap is closed, or
/// where a closed gap lies between the place and all openings.
/// @param nodes  number of bottom nodes
/// @param open   (bottom node) whether water can pass
std::vector<std::optional<GapRoute>> find_gap_routes(std::size_t nodes,
                                                     std::span<const BottomPath> paths,
                                                     std::span<const GapOpening> openings,
                                                     const std::vector<char>& open);

/// A place from which steam flows to an opening, at the start of a step.
struct GapPiece {
  double area = 0.0;      ///< [m2]; 2D [m], axisymmetric [m2/rad]
  double distance = 0.0;  ///< [m] from the opening
  double gap = 0.0;       ///< [m]
};

/// The width of the gap across the way to an opening. Towards the edge it stays the same; around a
/// hole it is the circumference, which grows outwards.
struct GapPassage {
  double width = 0.0;   ///< [m] at the opening; axisymmetric [m2/rad / m]
  double spread = 0.0;  ///< [1] growth of the width with the distance

  /// Width of a uniform passage with the same resistance to slow steam, between two distances.
  double mean_width(double from, double to) const;  ///< [m]
};

/// Pressure of the steam above that of the air [Pa] at each piece of a path.
///
/// The steam that the water gives off flows to the opening through the same gap. It loses one
/// velocity head where it leaves and, on its way, the friction of a channel of height g:
///   dp/ds = f rho v^2 / (4 g),   f = max(96 / Re, 0.316 Re^(-1/4)),   Re = 2 g rho v / mu.
/// Beyond the last wet piece nothing flows: the pressure stays the same.
///
/// @param pieces  from the opening inwards
/// @param steam   (piece) [kg/s] given off; 2D per metre, axisymmetric per radian
std::vector<double> steam_pressure(std::span<const GapPiece> pieces, std::span<const double> steam,
                                   const GapPassage& passage);

/// A drain hole as water and steam in the gap meet it.
struct GapHole {
  /// A bottom node over the hole.
  struct Node {
    std::size_t number = 0;
    double distance = 0.0;  ///< [m] from the rim; 0 over the hole
  };
  std::vector<Node> nodes;  ///< where no node lies over the hole, the nearest one
  double across = 0.0;      ///< [m] of the width of a stream that it takes up
  GapPassage passage;       ///< of the steam
};

/// @param places  (bottom node) [m] in the plan of a quarter slab
std::vector<GapHole> find_gap_holes(std::span<const DrainHole> holes,
                                    std::span<const std::array<double, 2>> places);

/// Water that comes down a column of a face to a place of the edge.
struct EdgeSupply {
  std::size_t edge = 0;  ///< bottom node
  Film film;
  double width = 0.0;  ///< [m] of the column; axisymmetric [m2/rad / m]
};

/// A place of the bottom at the start of a step.
struct GapSurface {
  double area = 0.0;         ///< [m2]; 2D [m], axisymmetric [m2/rad]
  double gap = 0.0;          ///< [m]
  double open = 0.0;         ///< [1] share of the place into which water gets
  double temperature = 0.0;  ///< [°C] of the slab
  double wetted = 0.0;       ///< [1]
  BottomPlace block;         ///< of which only the block's temperature and compliance are used
};

/// What the water in the gap does at one place of the bottom during one step.
struct GapPlace {
  double share = 0.0;       ///< [1] of the place that water touches
  WaterPlace water;         ///< there
  double block_flux = 0.0;  ///< [W/m2] of the whole place, from the block into the water
};

/// The water in the gap in one step.
struct GapStreams {
  std::vector<GapPlace> place;  ///< (bottom node)
  FaceWater water;              ///< `taken` is that of the block alone
  double steam_pressure = 0.0;  ///< [Pa] largest
  double steam_force = 0.0;     ///< [N/m]; billet [N/rad], solid [N]
};

/// Runs water from the edge into the open gap, one stream for each place of the edge: it takes the
/// shortest way to every place that is nearer to this place of the edge than to others, and is
/// marched along like the film of a face (march_film()), below the jet. The block warms it too.
///
/// At a hole that takes up a share of its width, a stream loses this share of its water; beyond it
/// the vapour film counts anew. Steam flows to the nearest opening, edge or hole.
/// @param law       the water of the faces, thrown off after GapWater::steam_reach
/// @param supplies  in any order; those to the same place are joined
/// @param instant   [s] end of the step @param time_step  [s]
GapStreams lay_gap_water(const GapWater& gap, const Water& law, std::span<const BottomPath> paths,
                         std::span<const GapSurface> bottom, std::span<const EdgeSupply> supplies,
                         std::span<const GapHole> holes, double instant, double time_step);

}  // namespace dccast::thermal
