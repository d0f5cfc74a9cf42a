#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/base/curve.hpp"

namespace dccast::thermal {

/// Face of a slab. The only side of a 2D section counts as wide.
enum class Face { wide, narrow };
/// Wide and narrow face of a slab; sections have the first alone.
inline constexpr std::size_t faces = 2;

/// The gap between a face and the mould, which opens as the shell shrinks.
struct MouldGap {
  double air_conductivity = 0.0;  ///< [W/(m K)]
  double emissivity = 0.0;        ///< [1] effective, of metal and wall
  double taper = 0.0;             ///< [1] by which the wall closes in downwards; negative: it opens
};

/// A cooling zone of the side: a band at a fixed distance below the metal level.
struct SideZone {
  std::string name;
  double from = 0.0;         ///< [m] below the metal level
  double to = 0.0;           ///< [m]
  Curve liquid_coefficient;  ///< [W/(m2 K)] of a liquid surface
  Curve solid_coefficient;   ///< [W/(m2 K)] of a solid surface; weighted by the liquid fraction
  Curve temperature;         ///< [°C] of the surroundings
  std::optional<Face> face;  ///< face to which the zone applies; absent: all faces
  /// The coefficients are those of contact, and the open gap adds to them (zone_flux()); absent:
  /// they hold whatever the gap.
  std::optional<MouldGap> gap{};
};

/// How a falling film wets hot metal, loses contact with it and boils away (cooling.hpp). Sources
/// stand in docs/water.md.
struct Wetting {
  double flow_exponent = 0.0;         ///< [1] of the flow in the critical flux
  double falling_film_share = 0.0;    ///< [1] critical flux of the falling film, of the jet's
  double jet_length = 0.0;            ///< [m] below the water line
  double rewetting_saturated = 0.0;   ///< [°C] rewetting temperature of water without subcooling
  double rewetting_rise = 0.0;        ///< [K] by flow and subcooling
  double rewetting_limit = 0.0;       ///< [°C]
  double rewetting_width = 0.0;       ///< [K] of the transition from wet to vapour film
  double lag = 0.0;                   ///< [s] in which a surface changes from one to the other
  double jet_film_coefficient = 0.0;  ///< [W/(m2 K)] through the vapour film under the jet
  double film_coefficient = 0.0;      ///< [W/(m2 K)] through the vapour film below the jet
  double throw_off_length = 0.0;      ///< [m] of vapour film after which the water leaves the face
  double least_flow = 0.0;            ///< [m2/s] that still covers the face
  double evaporation_from = 0.0;      ///< [°C] film temperature from which vapour leaves the film
};

/// Jet and falling film below the water line.
struct Water {
  /// Whether there is water at all; without it the side below the mould is dry.
  bool enabled = false;
  double from = 0.0;  ///< [m] below the metal level
  /// [m] below the metal level a wiper takes the water off; absent: it runs down to the butt
  std::optional<double> wiped_at{};
  double start = 0.0;                            ///< [s]
  Curve temperature;                             ///< [°C]
  double critical_heat_flux = 0.0;               ///< [W/m2]
  Curve critical_heat_flux_factor = Curve(1.0);  ///< [1] against time or cast length
  /// The critical flux is that of the jet at `full_flow` and 25 °C; all limits follow flow and film
  /// temperature, and the film's heat is marched down the face (water_film.hpp). Otherwise the
  /// critical flux holds everywhere, and no vapour film stands.
  bool boiling_follows_flow = false;
  Wetting wetting;
  double pulse_period = 0.0;  ///< [s] from one opening of the valve to the next; 0: no pulses
  double pulse_share = 0.0;   ///< [1] of the period in which the water runs
  double pulse_end = 0.0;     ///< [s] from then on the water runs continuously
  Curve coefficient;          ///< [W/(m2 K)]; not empty: replaces the law of Weckman and Niessen
};

/// A second row of jets below the first, on every face (SurfaceCooling::lay_column()).
struct SecondWater {
  double from = 0.0;   ///< [m] below the metal level, under the first water
  double start = 0.0;  ///< [s]
};

/// The block as a body: heat flows through its thickness under each point of the bottom.
struct BlockBody {
  double thickness = 0.0;            ///< [m]
  double conductivity = 0.0;         ///< [W/(m K)]
  double heat_capacity = 0.0;        ///< [J/(m3 K)]
  double cooling_coefficient = 0.0;  ///< [W/(m2 K)] of its lower side, to the water
};

/// Water that runs from the edge of the butt into the open gap (gap_water.hpp). None of these
/// figures has been measured on a butt; docs/bottom-block.md says what stands behind them.
struct GapWater {
  double inflow_share = 0.0;       ///< [1] of the water that reaches the edge, into the gap
  double touching_share = 0.0;     ///< [1] of the open gap's width that its streams cover, not 0
  double block_coefficient = 0.0;  ///< [W/(m2 K)] from the block into the water
  double steam_reach = 0.0;  ///< [m] of unbroken vapour film from which on steam keeps water out
};

/// A round hole through the bottom block of a quarter slab. On a plane of symmetry it stands for a
/// whole one.
struct DrainHole {
  double x = 0.0;         ///< [m] its centre from the planes of symmetry
  double y = 0.0;         ///< [m]
  double diameter = 0.0;  ///< [m]
};

/// The bottom block and what lies between it and the butt; table `cooling.bottom_block` of a case.
struct BottomBlock {
  /// [W/(m2 K)] against the time since the first metal: the shell shrinks away from the block after
  /// a certain time of contact, whenever the block starts.
  Curve contact_coefficient;
  double first_metal = 0.0;       ///< [s] time at which metal first stands on the block
  Curve gap_coefficient;          ///< [W/(m2 K)] against gap [m]
  Curve temperature_factor;       ///< [1] against surface temperature [°C]
  Curve temperature;              ///< [°C] against time; of a body its value at the start
  std::optional<BlockBody> body;  ///< absent: the block keeps the temperature of the table
  /// Water in gaps wider than `wet_gap`, once water has met the butt; absent: none gets in.
  std::optional<double> wet_coefficient{};  ///< [W/(m2 K)] from slab and from block to the water
  double wet_gap = 0.0;                     ///< [m]
  /// The same with a path from the edge, a mass flow and boiling; absent: the constant coefficient.
  std::optional<GapWater> gap_water{};
  std::vector<DrainHole> drain_holes{};  ///< through which water and steam leave the gap
  /// [m] gap that is open between block and slab at the start, against the distance from x = 0 and,
  /// in a quarter slab, from y = 0; the two are added. Empty: none.
  Curve profile_x, profile_y;
};

/// The metal level: `pouring` loses heat to the air, and the metal that enters brings its own;
/// `held` is kept at the casting temperature (Gamma_T,d of the paper); `insulated` passes nothing.
enum class Top { pouring, held, insulated };

/// How heat leaves the slab; table `cooling` of a case.
struct CoolingSpec {
  /// Zones of the side, each with its face; the first that covers a place applies.
  std::vector<SideZone> zones;
  Water water;
  std::optional<Water> narrow_water;  ///< on the narrow face; absent: as on the wide face
  std::optional<SecondWater> second_water{};
  BottomBlock bottom_block;
  double dry_coefficient = 0.0;      ///< [W/(m2 K)]
  double ambient_temperature = 0.0;  ///< [°C]
  Top top = Top::pouring;
  double level_coefficient = 0.0;  ///< [W/(m2 K)] from the level to the surroundings, if pouring

  /// Water of a face: its own where the case has one, else that of the wide face.
  const Water& water_of(Face face) const {
    return face == Face::narrow && narrow_water ? *narrow_water : water;
  }
};

}  // namespace dccast::thermal
