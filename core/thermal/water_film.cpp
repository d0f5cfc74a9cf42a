#include "core/thermal/water_film.hpp"

#include <algorithm>
#include <cmath>

namespace dccast::thermal {
namespace {

/// The vapour film counts as unbroken where less than this share [1] of the surface is wet.
constexpr double hardly_wetted = 0.1;

/// Heat [W] that warms a mass flow [kg/s] to 100 °C and evaporates it.
double heat_to_vapour(double mass_flow, double temperature) {
  return mass_flow *
         (water_specific_heat * std::max(0.0, boiling_point - temperature) + evaporation_heat);
}

/// The water of a column on its way down.
class Stream {
public:
  Stream(const Water& water, const Film& supply, double width)
      : from_(water.wetting.evaporation_from),
        width_(width),
        critical_factor_(supply.critical_factor),
        mass_flow_(water_density * supply.flow * width),
        temperature_(supply.temperature) {}

  Film film() const {
    return {temperature_, mass_flow_ / (water_density * width_), critical_factor_};
  }
  double capacity() const { return heat_to_vapour(mass_flow_, temperature_); }
  /// @param heat  [W], at most capacity()
  void take(double heat) {
    const double begin = temperature_, heat_capacity = mass_flow_ * water_specific_heat;
    const double below = heat_capacity * std::max(0.0, from_ - temperature_);
    temperature_ += std::min(heat, below) / heat_capacity;
    if (heat > below) {  // (100 °C - T) decays with the heat while the vapour's share grows
      const double rest = boiling_point - temperature_, range = boiling_point - from_;
      temperature_ = boiling_point - rest * std::exp(-(heat - below) / (range * heat_capacity));
    }
    mass_flow_ -= (heat - heat_capacity * (temperature_ - begin)) / evaporation_heat;
    mass_flow_ = std::max(mass_flow_, 0.0);
  }

private:
  double from_;             ///< [°C]
  double width_;            ///< [m]
  double critical_factor_;  ///< [1]
  double mass_flow_;        ///< [kg/s]
  double temperature_;      ///< [°C]
};

/// Mean wetted share [1] of a step: dw/dt = (final - w) / lag, integrated exactly.
double mean_wetted_share(const Wetting& wetting, double before, double final_share,
                         double time_step) {
  const double steps = time_step / wetting.lag;
  return final_share + (before - final_share) * -std::expm1(-steps) / steps;
}

}  // namespace

double film_capacity(const Film& film, double width) {
  return heat_to_vapour(water_density * film.flow * width, film.temperature);
}

Film joined(const Film& first, const Film& second) {
  const double flow = first.flow + second.flow;
  const auto mixed = [&](double Film::*value) {
    return (first.*value * first.flow + second.*value * second.flow) / flow;
  };
  return {mixed(&Film::temperature), flow, mixed(&Film::critical_factor)};
}

void reserve_heat(double heat, std::span<const WetPiece> pieces, std::span<WaterPlace> place) {
  double area = 0.0;
  for (std::size_t i = 0; i < place.size(); ++i) area += pieces[i].area;
  const double reserved = heat / area;
  for (WaterPlace& at : place) at.largest_flux -= reserved;
}

double wetted_after(const Wetting& wetting, double before, double in_the_end, double time_step) {
  return in_the_end + (before - in_the_end) * std::exp(-time_step / wetting.lag);
}

FilmEnd march_film(const Water& water, const Film& supply, double width, double time_step,
                   std::span<const WetPiece> pieces, std::vector<WaterPlace>& place) {
  const Wetting& w = water.wetting;
  Stream stream(water, supply, width);
  FilmEnd end;

  place.clear();
  double vapour = 0.0, area = 0.0;  // [m] of unbroken vapour film, [m2] of the pieces so far
  std::vector<double> flux;

  for (const WetPiece& piece : pieces) {
    const Film film = stream.film();
    end.boiled_away = film.flow < w.least_flow;
    end.thrown_off = vapour > w.throw_off_length;
    if (end.boiled_away || end.thrown_off) break;

    const double depth = piece.at.distance - water.from;
    const double surface = piece.surface_temperature;
    const double rewetting = rewetting_temperature(w, film);

    const WaterPlace here{.film = film,
                          .wetted = mean_wetted_share(
                              w, piece.wetted, wet_in_the_end(w, surface, rewetting), time_step),
                          .rewetting = rewetting,
                          .critical_heat_flux = critical_heat_flux(water, film, depth),
                          .film_coefficient = film_coefficient(w, film, depth)};

    // A piece takes at most the heat that boils away the whole stream.
    const double wanted = water_flux(water, here, {surface, 0.0}, piece.at).flux;
    const double taken = std::min(wanted * piece.area, stream.capacity());
    stream.take(taken);

    flux.push_back(taken / piece.area);
    area += piece.area;
    place.push_back(here);

    if (piece.wall_coefficient > 0.0) {
      const double excess = std::max(0.0, piece.wall_temperature - stream.film().temperature);
      const double heat = std::min(piece.wall_coefficient * excess * piece.area, stream.capacity());
      stream.take(heat);
      place.back().wall_flux = heat / piece.area;
    }

    // The stream leaves the face only at an unbroken vapour film below the jet.
    if (depth >= w.jet_length)
      vapour = here.wetted < hardly_wetted ? vapour + piece.area / width : 0.0;
  }

  // Iterations may move heat between pieces: each may take only a part of the remaining stream.
  const double spare = area > 0.0 ? stream.capacity() / area : 0.0;
  for (std::size_t i = 0; i < place.size(); ++i) place[i].largest_flux = flux[i] + spare;

  end.film = stream.film();
  return end;
}

}  // namespace dccast::thermal
