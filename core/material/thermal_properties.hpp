#pragma once

#include <vector>

#include "core/material/alloy_card.hpp"

namespace dccast::material {

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

  bool isothermal() const { return liquidus_ == solidus_; }
  void build_segments(const AlloyCard& card);
  Segment segment_between(const AlloyCard& card, double left, double right, End end) const;
  void append(Segment segment);
  void append_isothermal_change(const AlloyCard& card, double temperature);
  void fix_origin();
  const Segment& segment_at_temperature(double temperature) const;
  const Segment& segment_at_enthalpy(double enthalpy) const;
  static double first_guess(const Segment& segment, double wanted, double whole);
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
