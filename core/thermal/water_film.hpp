#pragma once

#include <span>
#include <vector>

#include "core/thermal/cooling.hpp"

namespace dccast::thermal {

/// A piece of a face that water runs over, at the start of a step.
struct WetPiece {
  double area = 0.0;  ///< [m2]; 2D [m], axisymmetric [m2/rad]
  SidePlace at;
  double surface_temperature = 0.0;  ///< [°C]
  double wetted = 0.0;               ///< [1]
  // Another wall beside the film, that of a gap.
  double wall_coefficient = 0.0;  ///< [W/(m2 K)]
  double wall_temperature = 0.0;  ///< [°C]
};

/// The water of one face, or of the gap under the butt, in one step.
struct FaceWater {
  double capacity = 0.0;     ///< [W/m]; billet [W/rad], solid [W]: heat that all of it could take
  double taken = 0.0;        ///< [W/m] the same units
  double area = 0.0;         ///< [m]; [m2/rad], [m2] that it runs over
  double wetted = 0.0;       ///< [m] of it that is not under a vapour film
  bool boiled_away = false;  ///< somewhere less than the least flow is left
  bool thrown_off = false;   ///< somewhere the vapour film has thrown it off the face

  double share() const { return capacity > 0.0 ? taken / capacity : 0.0; }  ///< [1]
  double wetted_share() const { return area > 0.0 ? wetted / area : 0.0; }  ///< [1]
};

/// The film below the last piece that it runs over, and why it does not reach the bottom of the
/// slab, if it does not.
struct FilmEnd {
  Film film;
  /// Why the film ended above this place: too little water is left, or steam has thrown it off.
  bool boiled_away = false;
  bool thrown_off = false;
};

/// Heat that warms the water of a column to 100 °C and evaporates it [W]; 2D [W/m].
/// @param width  [m] of the column along the perimeter; axisymmetric [m2/rad / m]
double film_capacity(const Film& supply, double width);

/// Two films that meet: their flows, the heat and the gas in them add.
Film joined(const Film& first, const Film& second);

/// Marches the film of one column of a face down from the water line.
///
/// The film takes the flux that the surface temperatures at the start of the step give; it warms,
/// and from `evaporation_from` on a growing share of the heat evaporates water:
///   dm = -p q dA / h_fg,  dT = (1 - p) q dA / (m c),  p = (T - T_e) / (100 °C - T_e).
/// Water leaves the face for good after `throw_off_length` of vapour film below the jet, or where
/// less than `least_flow` is left; the face is dry below.
///
/// Film temperature and flow hold for the whole step. The flux may rise in it: each piece may take
/// what the march gives it and its part, by area, of what the film has left at its end. So no face
/// gives off more than its water can take. What another wall gives off follows from its temperature
/// at the start of the step and does not rise.
///
/// A surface that the film wets in the end is wet after `lag`; w is the mean over the step of
///   dw/dt = (w_e(T) - w) / lag.
///
/// @param supply     at the water line
/// @param time_step  [s]
/// @param width    [m] of the column along the perimeter; axisymmetric [m2/rad / m]
/// @param pieces   from the water line down
/// @param place    overwritten, (piece); those beyond the end of the film are missing
FilmEnd march_film(const Water& water, const Film& supply, double width, double time_step,
                   std::span<const WetPiece> pieces, std::vector<WaterPlace>& place);

/// Keeps a part of what a film has left at its end for places that it runs on to.
/// @param heat    [W] @param pieces  of the film
/// @param place   what march_film() gave, one or more
void reserve_heat(double heat, std::span<const WetPiece> pieces, std::span<WaterPlace> place);

/// Wetted share of a surface [1] after a step. @param before  [1] @param in_the_end  [1]
/// @param time_step  [s]
double wetted_after(const Wetting& wetting, double before, double in_the_end, double time_step);

}  // namespace dccast::thermal
