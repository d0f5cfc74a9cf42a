#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/thermal/heat_forms.hpp"
#include "core/thermal/water_film.hpp"

namespace dccast::thermal {

/// The shortest way through the open gap from the edge of the butt to a place.
struct GapRoute {
  std::size_t edge = 0;   ///< bottom node at which the water enters
  double distance = 0.0;  ///< [m]
};

/// The way of the water to each place of the bottom; none where the gap is closed, or where a
/// closed gap lies between the place and the edge.
/// @param nodes  number of bottom nodes
/// @param edge   bottom nodes at the edge
/// @param open   (bottom node) whether water can pass
std::vector<std::optional<GapRoute>> find_gap_routes(std::size_t nodes,
                                                     std::span<const BottomPath> paths,
                                                     std::span<const std::size_t> edge,
                                                     const std::vector<char>& open);

/// A place that the water of one edge node runs through, at the start of a step.
struct GapPiece {
  double area = 0.0;      ///< [m2]; 2D [m], axisymmetric [m2/rad]
  double distance = 0.0;  ///< [m] from the edge
  double gap = 0.0;       ///< [m]
};

/// Pressure of the steam above that of the air [Pa] at each piece of a path.
///
/// The steam that the water gives off flows back to the edge through the same gap. It loses one
/// velocity head where it leaves and, on its way, the friction of a channel of height g:
///   dp/ds = f rho v^2 / (4 g),   f = max(96 / Re, 0.316 Re^(-1/4)),   Re = 2 g rho v / mu.
/// Beyond the last wet piece nothing flows: the pressure stays the same.
///
/// @param pieces  from the edge inwards
/// @param steam   (piece) [kg/s] given off; 2D per metre, axisymmetric per radian
/// @param width   [m] of the path along the edge; axisymmetric [m2/rad / m]
std::vector<double> steam_pressure(std::span<const GapPiece> pieces, std::span<const double> steam,
                                   double width);

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
/// @param law       the water of the faces, thrown off after GapWater::steam_reach
/// @param supplies  in any order; those to the same place are joined
/// @param instant   [s] end of the step @param time_step  [s]
GapStreams lay_gap_water(const GapWater& gap, const Water& law,
                         std::span<const BottomPath> paths, std::span<const GapSurface> bottom,
                         std::span<const EdgeSupply> supplies, double instant, double time_step);

}  // namespace dccast::thermal
