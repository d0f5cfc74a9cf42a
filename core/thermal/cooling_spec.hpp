#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/base/curve.hpp"

namespace dccast::thermal {

/// Face of a slab. The only side of a 2D section counts as wide.
enum class Face { wide, narrow };
inline constexpr std::size_t faces = 2;

/// A cooling zone of the side: a band at a fixed distance below the metal level.
struct SideZone {
  std::string name;
  double from = 0.0;         ///< [m] below the metal level
  double to = 0.0;           ///< [m]
  Curve liquid_coefficient;  ///< [W/(m2 K)] of a liquid surface
  Curve solid_coefficient;   ///< [W/(m2 K)] of a solid surface; weighted by the liquid fraction
  Curve temperature;         ///< [°C] of the surroundings
  std::optional<Face> face;  ///< face to which the zone applies; absent: all faces
};

/// Jet and falling film below the water line.
struct Water {
  bool enabled = true;
  double from = 0.065;              ///< [m] below the metal level
  double start = 0.0;               ///< [s]
  Curve temperature;                ///< [°C]
  double critical_heat_flux = 4e6;  ///< [W/m2]
  bool film_boiling = false;
  double film_boiling_coefficient = 500.0;  ///< [W/(m2 K)]
  double film_boiling_above = 350.0;        ///< [°C]
  bool boiling_follows_flow =
      false;  ///< the three values above depend on flow and temperature, boiling.hpp
  double pulse_period = 0.0;  ///< [s] from one opening of the valve to the next; 0: no pulses
  double pulse_share = 0.5;   ///< [1] of the period in which the water runs
  double pulse_end = 0.0;     ///< [s] from then on the water runs continuously
  Curve coefficient;          ///< [W/(m2 K)]; not empty: replaces the law of Weckman and Niessen
};

struct BottomBlock {
  Curve contact_coefficient;  ///< [W/(m2 K)] against time
  Curve gap_coefficient;      ///< [W/(m2 K)] against gap [m]
  Curve temperature_factor;   ///< [1] against surface temperature [°C]
  Curve temperature;          ///< [°C] against time
  /// [m] initial distance of the block below the slab, against the distance from x = 0 and, in a
  /// quarter slab, from y = 0; the two are added. Empty: flat.
  Curve profile_x, profile_y;
};

enum class Top { pouring, insulated };

/// How heat leaves the slab; table `cooling` of a case.
struct CoolingSpec {
  std::vector<SideZone> zones;
  Water water;
  std::optional<Water> narrow_water;  ///< on the narrow face; absent: as on the wide face
  BottomBlock bottom_block;
  double dry_coefficient = 20.0;      ///< [W/(m2 K)]
  double ambient_temperature = 25.0;  ///< [°C]
  Top top = Top::pouring;

  const Water& water_of(Face face) const {
    return face == Face::narrow && narrow_water ? *narrow_water : water;
  }
};

}  // namespace dccast::thermal
