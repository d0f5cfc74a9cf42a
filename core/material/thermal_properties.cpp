#include "core/material/thermal_properties.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace dccast::material {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// Points of the tables that are closer than this [K] count as one.
constexpr double same_temperature = 1e-10;

/// A quantity that is linear in t = T - anchor.
struct Linear {
  double value = 0.0;
  double slope = 0.0;
};

Linear linear_between(double left, double right, double width) {
  return {left, (right - left) / width};
}

double cubic(double c1, double c2, double c3, double t) {
  return t * (c1 + t * (c2 + t * c3));
}

double cubic_derivative(double c1, double c2, double c3, double t) {
  return c1 + t * (2.0 * c2 + t * 3.0 * c3);
}

double curve_or_one(const Curve& curve, double abscissa) {
  return curve.empty() ? 1.0 : curve(abscissa);
}

/// Sorted temperatures at which one of the tables has a kink, and 0 °C, the origin of H.
std::vector<double> kinks(const AlloyCard& card) {
  std::vector<double> points{0.0, card.solidus, card.liquidus};
  for (const Curve* curve :
       {&card.density, &card.specific_heat, &card.conductivity, &card.liquid_fraction}) {
    if (!curve->constant()) points.insert(points.end(), curve->at().begin(), curve->at().end());
  }

  // The factor stands against the liquid fraction: its points become temperatures.
  for (const double fraction : card.melt_conductivity_factor.at()) {
    if (fraction > 0.0 && fraction < 1.0) {
      points.push_back(temperature_of_fraction(card, fraction));
    }
  }

  std::sort(points.begin(), points.end());
  const auto same = [](double a, double b) { return b - a < same_temperature; };
  points.erase(std::unique(points.begin(), points.end(), same), points.end());
  return points;
}

}  // namespace

ThermalProperties::ThermalProperties(const AlloyCard& card)
    : solidus_(card.solidus), liquidus_(card.liquidus) {
  AlloyCard of_heat = card;
  if (card.fed_density) of_heat.density = Curve(*card.fed_density);
  build_segments(of_heat);
  fix_origin();

  // The searches need the starts of the segments by themselves.
  for (std::size_t i = 1; i < segments_.size(); ++i) {
    start_temperature_.push_back(segments_[i].anchor);
    start_enthalpy_.push_back(segments_[i].enthalpy);
  }

  // At an isothermal change the solidus is where the latent heat begins to enter.
  liquidus_enthalpy_ = enthalpy(liquidus_);
  solidus_enthalpy_ = enthalpy(solidus_);
  for (const Segment& segment : segments_) {
    if (!segment.isothermal) continue;
    solidus_enthalpy_ = segment.enthalpy;
  }
}

ThermalProperties::Segment ThermalProperties::segment_between(const AlloyCard& card, double left,
                                                              double right, End end) const {
  const double width = right - left;
  const double middle = 0.5 * (left + right);
  const bool mushy = !isothermal() && middle > solidus_ && middle < liquidus_;
  double fraction_left = middle < solidus_ ? 0.0 : 1.0;
  double fraction_right = fraction_left;
  Segment segment;
  if (mushy) {
    fraction_left = liquid_fraction_at(card, left);
    fraction_right = liquid_fraction_at(card, right);
    segment.liquid_fraction_slope = card.liquid_fraction.empty()
                                        ? 1.0 / (liquidus_ - solidus_)
                                        : (fraction_right - fraction_left) / width;
  }
  segment.anchor = end == End::lowest ? right : left;
  segment.width = end == End::none ? width : infinite;
  segment.liquid_fraction = fraction_left;

  const auto of = [&](const Curve& curve) {
    return end == End::none ? linear_between(curve(left), curve(right), width)
                            : Linear{curve(segment.anchor), 0.0};
  };
  const Linear density = of(card.density);
  const Linear heat = of(card.specific_heat);
  const Linear at_rest = of(card.conductivity);
  const Linear factor =
      linear_between(curve_or_one(card.melt_conductivity_factor, fraction_left),
                     curve_or_one(card.melt_conductivity_factor, fraction_right), width);
  // Latent heat of eq. (1): L dfl/dT, L / (Tl - Ts) without a table, times the density's integral.
  double latent = 0.0;
  if (mushy) {
    latent = card.liquid_fraction.empty() ? card.latent_heat / (liquidus_ - solidus_)
                                          : card.latent_heat * segment.liquid_fraction_slope;
  }
  segment.h1 = density.value * (heat.value + latent);
  segment.h2 = 0.5 * (density.value * heat.slope + density.slope * (heat.value + latent));
  segment.h3 = density.slope * heat.slope / 3.0;
  segment.k1 = at_rest.value * factor.value;
  segment.k2 = 0.5 * (at_rest.value * factor.slope + at_rest.slope * factor.value);
  segment.k3 = at_rest.slope * factor.slope / 3.0;
  return segment;
}

void ThermalProperties::build_segments(const AlloyCard& card) {
  const std::vector<double> points = kinks(card);
  append(segment_between(card, points.front() - 1.0, points.front(), End::lowest));
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (isothermal() && std::abs(points[i] - solidus_) < same_temperature &&
        card.latent_heat > 0.0) {
      append_isothermal_change(card, points[i]);
    }
    const bool last = i + 1 == points.size();
    append(segment_between(card, points[i], last ? points[i] + 1.0 : points[i + 1],
                           last ? End::highest : End::none));
  }
}

/// Appends a segment that continues enthalpy and Kirchhoff variable from the last one.
void ThermalProperties::append(Segment segment) {
  const bool first = segments_.empty();
  segment.enthalpy = first ? 0.0 : segments_.back().enthalpy + content_of_last_;
  segment.kirchhoff = first ? 0.0 : segments_.back().kirchhoff + kirchhoff_of_last_;

  const double width = std::isinf(segment.width) ? 0.0 : segment.width;
  content_of_last_ = cubic(segment.h1, segment.h2, segment.h3, width);
  segment.slope_at_start = 1.0 / segment.h1;
  segment.slope_at_end = 1.0 / cubic_derivative(segment.h1, segment.h2, segment.h3, width);
  kirchhoff_of_last_ = cubic(segment.k1, segment.k2, segment.k3, width);

  // Upper bound of the diffusivity: largest conductivity over smallest heat capacity of both ends.
  const double conductivity =
      std::max(segment.k1, cubic_derivative(segment.k1, segment.k2, segment.k3, width));
  const double capacity =
      std::min(segment.h1, cubic_derivative(segment.h1, segment.h2, segment.h3, width));
  largest_diffusivity_ = std::max(largest_diffusivity_, conductivity / capacity);

  segments_.push_back(segment);
}

void ThermalProperties::append_isothermal_change(const AlloyCard& card, double temperature) {
  const double latent = card.density(temperature) * card.latent_heat;
  Segment change;
  change.isothermal = true;
  change.anchor = temperature;
  change.enthalpy = segments_.back().enthalpy + content_of_last_;
  change.kirchhoff = segments_.back().kirchhoff + kirchhoff_of_last_;
  change.liquid_fraction_slope = 1.0 / latent;
  content_of_last_ = latent;
  kirchhoff_of_last_ = 0.0;
  segments_.push_back(change);
}

/// Shifts enthalpy and Kirchhoff variable so that both vanish at 0 °C.
void ThermalProperties::fix_origin() {
  // 0 °C is a point of the tables and so the anchor of a segment.
  double enthalpy_at_zero = 0.0;
  double kirchhoff_at_zero = 0.0;
  for (const Segment& segment : segments_) {
    if (std::abs(segment.anchor) < same_temperature) {
      enthalpy_at_zero = segment.enthalpy;
      kirchhoff_at_zero = segment.kirchhoff;
    }
  }

  for (Segment& segment : segments_) {
    segment.enthalpy -= enthalpy_at_zero;
    segment.kirchhoff -= kirchhoff_at_zero;
  }
}

const ThermalProperties::Segment& ThermalProperties::segment_at_temperature(
    double temperature) const {
  const auto next =
      std::upper_bound(start_temperature_.begin(), start_temperature_.end(), temperature);
  return segments_[static_cast<std::size_t>(next - start_temperature_.begin())];
}

const ThermalProperties::Segment& ThermalProperties::segment_at_enthalpy(double enthalpy) const {
  const auto next = std::upper_bound(start_enthalpy_.begin(), start_enthalpy_.end(), enthalpy);
  return segments_[static_cast<std::size_t>(next - start_enthalpy_.begin())];
}

/// Cubic through both ends of the segment with its slopes there, from which two of Newton's steps
/// reach the root to rounding.
double ThermalProperties::first_guess(const Segment& segment, double wanted, double whole) {
  const double share = wanted / whole, rest = 1.0 - share;
  const double curved = share * share * (3.0 - 2.0 * share) * segment.width;
  return curved +
         share * rest * whole * (rest * segment.slope_at_start - share * segment.slope_at_end);
}

double ThermalProperties::invert(const Segment& segment, double enthalpy, double enthalpy_at_end) {
  const double wanted = enthalpy - segment.enthalpy;
  if (segment.h2 == 0.0 && segment.h3 == 0.0) return wanted / segment.h1;

  // Newton's method on a monotone cubic, kept inside the segment by bisection.
  double low = 0.0;
  double high = segment.width;
  double t = first_guess(segment, wanted, enthalpy_at_end - segment.enthalpy);

  for (int iteration = 0; iteration < 60; ++iteration) {
    const double excess = cubic(segment.h1, segment.h2, segment.h3, t) - wanted;
    (excess > 0.0 ? high : low) = t;

    double next = t - excess / cubic_derivative(segment.h1, segment.h2, segment.h3, t);
    if (next < low || next > high) next = 0.5 * (low + high);

    const double change = std::abs(next - t);
    t = next;
    if (change <= 1e-15 * (std::abs(segment.anchor) + segment.width)) break;
  }
  return t;
}

ThermalState ThermalProperties::state(double enthalpy) const {
  const Segment& segment = segment_at_enthalpy(enthalpy);

  ThermalState state;
  state.temperature = segment.anchor;
  state.kirchhoff = segment.kirchhoff;

  // In an isothermal change the enthalpy alone determines how much has melted.
  if (segment.isothermal) {
    state.liquid_fraction = segment.liquid_fraction_slope * (enthalpy - segment.enthalpy);
    state.liquid_fraction_derivative = segment.liquid_fraction_slope;
    return state;
  }

  const bool closed = &segment != &segments_.back();
  const double t = invert(segment, enthalpy, closed ? (&segment + 1)->enthalpy : 0.0);

  state.temperature += t;
  state.kirchhoff += cubic(segment.k1, segment.k2, segment.k3, t);
  state.liquid_fraction = segment.liquid_fraction + segment.liquid_fraction_slope * t;

  state.temperature_derivative = 1.0 / cubic_derivative(segment.h1, segment.h2, segment.h3, t);
  state.kirchhoff_derivative =
      cubic_derivative(segment.k1, segment.k2, segment.k3, t) * state.temperature_derivative;
  state.liquid_fraction_derivative = segment.liquid_fraction_slope * state.temperature_derivative;
  return state;
}

double ThermalProperties::enthalpy(double temperature) const {
  const Segment& segment = segment_at_temperature(temperature);
  return segment.enthalpy + cubic(segment.h1, segment.h2, segment.h3, temperature - segment.anchor);
}

double ThermalProperties::enthalpy_derivative(double temperature) const {
  const Segment& segment = segment_at_temperature(temperature);
  return cubic_derivative(segment.h1, segment.h2, segment.h3, temperature - segment.anchor);
}

double ThermalProperties::kirchhoff(double temperature) const {
  const Segment& segment = segment_at_temperature(temperature);
  return segment.kirchhoff +
         cubic(segment.k1, segment.k2, segment.k3, temperature - segment.anchor);
}

double ThermalProperties::conductivity(double temperature) const {
  const Segment& segment = segment_at_temperature(temperature);
  return cubic_derivative(segment.k1, segment.k2, segment.k3, temperature - segment.anchor);
}

}  // namespace dccast::material
