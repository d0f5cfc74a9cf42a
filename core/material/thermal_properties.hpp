#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/material/alloy_card.hpp"

/// Liquid and solid fraction of a card's mush against temperature [°C], and back.
namespace dccast::material {

/// Liquid fraction [1] from the card's table, or linear between solidus and liquidus.
/// @param temperature  [°C]
inline double liquid_fraction_at(const AlloyCard& card, double temperature) {
  if (!card.liquid_fraction.empty()) return card.liquid_fraction(temperature);
  if (card.liquidus <= card.solidus) return temperature < card.liquidus ? 0.0 : 1.0;
  return std::clamp((temperature - card.solidus) / (card.liquidus - card.solidus), 0.0, 1.0);
}

/// Temperature at which the liquid fraction first reaches a value [°C]. @param fraction  [1] 0 to 1
inline double temperature_of_fraction(const AlloyCard& card, double fraction) {
  const Curve& table = card.liquid_fraction;
  if (table.empty() || table.constant())
    return card.solidus + fraction * (card.liquidus - card.solidus);
  const auto right = std::lower_bound(table.value().begin() + 1, table.value().end(), fraction);
  if (right == table.value().end()) return table.at().back();
  const std::size_t i = std::size_t(right - table.value().begin());
  const double rise = table.value()[i] - table.value()[i - 1];
  const double share = rise > 0.0 ? (fraction - table.value()[i - 1]) / rise : 0.0;
  return table.at()[i - 1] + share * (table.at()[i] - table.at()[i - 1]);
}

/// @param temperature [°C] @return [1]
inline double solid_fraction_at(const AlloyCard& card, double temperature) {
  return 1.0 - liquid_fraction_at(card, temperature);
}

/// Factor on the conductivity of the melt for its own convection, by the size of the section
/// (docs/heat.md).
///
/// The buoyancy that drives the convection grows with the cube of the length over which the melt
/// cools (Grashof number), so the gain does. It acts in the melt between the dendrites from a
/// liquid fraction of 0.3 and fully from 0.8 on, as thermal models of casting use it.
/// @param gain  [1] of the conductivity in a section 450 mm across
/// @param size  [m] diameter of a billet, thickness of a slab
/// @return      [1] against liquid fraction; at most 20, from where on the melt is isothermal
inline Curve melt_stirring(double gain, double size) {
  constexpr double reference_size = 0.45;  // [m] the billet in which the gain was measured
  constexpr double largest_factor = 20.0;

  const double factor = 1.0 + gain * std::pow(size / reference_size, 3);
  return Curve(Abscissa::liquid_fraction, {0.3, 0.8}, {1.0, std::min(factor, largest_factor)});
}

/// A property of the mush, weighted by the fractions of solid and liquid: fs solid(T) + fl liquid.
/// Tables that are linear from solidus to liquidus instead would let an alloy that is 90 % solid
/// far above its solidus shrink by as much again as it has left to.
/// @param card    with solidus and liquidus; its liquid fraction is linear where it has no table
/// @param solid   against temperature [any unit]; used up to the liquidus
/// @param liquid  at and above the liquidus [the same unit]
/// @return        against temperature, linear between points at most 2.5 K apart in the mush
inline Curve mixed_by_fraction(const AlloyCard& card, const Curve& solid, double liquid) {
  constexpr double spacing = 2.5;     // [K]
  constexpr double most_parts = 1e4;  // a range out of all proportion is a fault of its own
  std::vector<double> at, value;
  const auto add = [&](double t) {
    const double fraction = t >= card.liquidus ? 1.0 : liquid_fraction_at(card, t);
    at.push_back(t);
    value.push_back((1.0 - fraction) * solid(t) + fraction * liquid);
  };

  // Below the solidus the table of the solid holds as it is.
  if (!solid.constant())
    for (const double t : solid.at())
      if (t < card.solidus) add(t);

  if (card.liquidus <= card.solidus) {   // a pure metal: a jump
    constexpr double half_width = 0.01;  // [K]
    at.insert(at.end(), {card.liquidus - half_width, card.liquidus + half_width});
    value.insert(value.end(), {solid(card.liquidus), liquid});
    return Curve(Abscissa::temperature, std::move(at), std::move(value));
  }

  // In the mush, add points between the kinks of both tables: the product is not linear.
  std::vector<double> kinks{card.solidus, card.liquidus};
  for (const Curve* curve : {&solid, &card.liquid_fraction})
    if (!curve->constant()) kinks.insert(kinks.end(), curve->at().begin(), curve->at().end());
  std::erase_if(kinks, [&](double t) { return t < card.solidus || t > card.liquidus; });
  std::sort(kinks.begin(), kinks.end());
  kinks.erase(std::unique(kinks.begin(), kinks.end()), kinks.end());

  for (std::size_t i = 0; i < kinks.size(); ++i) {
    add(kinks[i]);
    if (i + 1 == kinks.size()) break;
    const double width = kinks[i + 1] - kinks[i];
    const int parts = static_cast<int>(std::min(width / spacing, most_parts)) + 1;
    for (int k = 1; k < parts; ++k) add(kinks[i] + width * k / parts);
  }

  return Curve(Abscissa::temperature, std::move(at), std::move(value));
}

/// The coherency temperature that corresponds to a solid fraction [°C]: at 1 the solidus, at 0 the
/// liquidus. @param solid_fraction  [1]
inline double coherency_at(const AlloyCard& card, double solid_fraction) {
  return temperature_of_fraction(card, 1.0 - solid_fraction);
}

/// Density of the mixture at a solid fraction [kg/m3]. @param solid_fraction  [1]
inline double density_at_solid_fraction(const AlloyCard& card, double solid_fraction) {
  constexpr double below_the_jump = 0.02;  // [K] of a pure metal, mixed_by_fraction()
  const double jump = card.liquidus > card.solidus ? 0.0 : below_the_jump;
  return card.density(temperature_of_fraction(card, 1.0 - solid_fraction) - jump);
}

/// State of the metal at one enthalpy, with its derivatives by the enthalpy.
struct ThermalState {
  double temperature = 0.0;                 ///< T [°C]
  double kirchhoff = 0.0;                   ///< Theta [W/m]
  double liquid_fraction = 0.0;             ///< [1], 0 to 1
  double temperature_derivative = 0.0;      ///< dT/dH [K m3/J], zero inside an isothermal change
  double kirchhoff_derivative = 0.0;        ///< dTheta/dH [m2/s], never negative
  double liquid_fraction_derivative = 0.0;  ///< dfl/dH [m3/J], never negative
};

/// Enthalpy, conductivity and liquid fraction of an alloy, paper eq. (1) and (2).
///
/// H(T) is counted from 0 °C, per volume. Density, specific heat, conductivity and melt factor are
/// linear between their points, so that H and the Kirchhoff function Theta(T) = int k dT are cubics
/// between them. Both are integrated exactly once, when the card is read, and evaluated by
/// bisection. Where solidus and liquidus coincide H(T) jumps by rho(T_s) L; T(H), Theta(H) and
/// fl(H) stay single valued, which is why the heat solver's unknown is H.
///
/// In a mushy interval the liquid fraction follows the card's table, or is linear in T; in both
/// cases it goes from 0 to 1, so that all of L is released. The conductivity is curve(T) times the
/// melt factor at the liquid fraction (convection in the melt).
///
/// A volume that freezes gains metal: melt flows in while it shrinks. The density at its
/// temperature leaves out the heat of this metal, 3 to 6 % of the latent heat, and counts metal
/// twice that contracts later. With a fed density rho_f the volume stores heat by the mass that it
/// holds in the end, H = rho_f h(T) (docs/heat.md).
///
/// Units: in all functions enthalpy H [J/m3], temperature T [°C], Kirchhoff function Theta [W/m].
class ThermalProperties {
public:
  /// @param card  a checked card: curves increasing and positive, solidus not above liquidus
  explicit ThermalProperties(const AlloyCard& card);

  /// T, Theta, fl and their derivatives at enthalpy H [J/m3]; at a kink the derivative to its
  /// right.
  ThermalState state(double enthalpy) const;

  double temperature(double enthalpy) const { return state(enthalpy).temperature; }  ///< [°C]
  double liquid_fraction(double enthalpy) const {
    return state(enthalpy).liquid_fraction;
  }  ///< [1]

  /// H [J/m3] at T [°C]; at the temperature of an isothermal change the enthalpy of the liquid.
  double enthalpy(double temperature) const;
  /// dH/dT [J/(m3 K)], including the latent heat of a mushy interval, but not that of an isothermal
  /// change.
  double enthalpy_derivative(double temperature) const;
  /// Theta [W/m], zero at 0 °C.
  double kirchhoff(double temperature) const;
  /// k [W/(m K)] with the melt factor; the derivative of the Kirchhoff function.
  double conductivity(double temperature) const;

  double solidus() const { return solidus_; }    ///< [°C]
  double liquidus() const { return liquidus_; }  ///< [°C]
  /// Enthalpy released between liquid at the liquidus and solid at the solidus [J/m3].
  double solidification_enthalpy() const { return liquidus_enthalpy_ - solidus_enthalpy_; }
  double solidus_enthalpy() const { return solidus_enthalpy_; }    ///< [J/m3] all solid
  double liquidus_enthalpy() const { return liquidus_enthalpy_; }  ///< [J/m3] all liquid
  /// Largest dTheta/dH of the alloy [m2/s]: a bound on the thermal diffusivity.
  double largest_diffusivity() const { return largest_diffusivity_; }

private:
  /// Interval between neighbouring points of the tables: cubics in t = T - anchor. The isothermal
  /// change is a segment of zero width in T.
  struct Segment {
    double anchor = 0.0;                  ///< [°C]
    double width = 0.0;                   ///< [K]; infinite at the ends
    double enthalpy = 0.0;                ///< [J/m3] at the anchor
    double kirchhoff = 0.0;               ///< [W/m] at the anchor
    double h1 = 0.0, h2 = 0.0, h3 = 0.0;  ///< H - H(anchor) = h1 t + h2 t^2 + h3 t^3 [J/m3]
    double k1 = 0.0, k2 = 0.0, k3 = 0.0;  ///< the same for Theta [W/m]
    double slope_at_start = 0.0, slope_at_end = 0.0;  ///< dT/dH [K m3/J]
    double liquid_fraction = 0.0;                     ///< [1] at the anchor
    double liquid_fraction_slope = 0.0;               ///< [1/K]; [m3/J] in an isothermal change
    bool isothermal = false;
  };

  enum class End { none, lowest, highest };

  /// A pure metal or eutectic: liquidus and solidus coincide.
  bool isothermal() const { return liquidus_ == solidus_; }
  /// Divides the temperatures at the points of all tables, so that each segment is smooth.
  void build_segments(const AlloyCard& card);
  /// The segment between two temperatures [°C].
  Segment segment_between(const AlloyCard& card, double left, double right, End end) const;
  /// Appends a segment that continues enthalpy and Kirchhoff variable from the last one.
  void append(Segment segment);
  /// Appends the latent heat that is released at one temperature [°C].
  void append_isothermal_change(const AlloyCard& card, double temperature);
  /// Shifts enthalpy and Kirchhoff variable so that both vanish at 0 °C.
  void fix_origin();
  /// The segment that holds a value; the first or last one outside the table.
  const Segment& segment_at_temperature(double temperature) const;
  const Segment& segment_at_enthalpy(double enthalpy) const;
  /// Starting value of invert() [K]: the cubic through both ends of the segment with its slopes
  /// there, from which two of Newton's steps reach the root to rounding.
  static double first_guess(const Segment& segment, double wanted, double whole);
  /// Distance from the anchor of a segment at which it has an enthalpy [K], by Newton's method.
  static double invert(const Segment& segment, double enthalpy, double enthalpy_at_end);

  double solidus_;                  ///< [°C]
  double liquidus_;                 ///< [°C]
  double solidus_enthalpy_ = 0.0;   ///< [J/m3]
  double liquidus_enthalpy_ = 0.0;  ///< [J/m3]
  double largest_diffusivity_ = 0.0;
  double content_of_last_ =
      0.0;  ///< [J/m3] across the last segment; used while the segments are built
  double kirchhoff_of_last_ = 0.0;  ///< [W/m]
  std::vector<Segment> segments_;
  std::vector<double> start_temperature_;  ///< [°C] of each segment but the first
  std::vector<double> start_enthalpy_;     ///< [J/m3] of each segment but the first
};

}  // namespace dccast::material
