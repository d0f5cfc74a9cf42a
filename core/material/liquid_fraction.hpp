#pragma once

#include <algorithm>
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

/// A property of the mush, weighted by the fractions of solid and liquid: fs solid(T) + fl liquid.
/// Tables that are linear from solidus to liquidus instead would let an alloy that is 90 % solid
/// far above its solidus shrink by as much again as it has left to.
/// @param card    with solidus, liquidus and liquid fraction
/// @param solid   against temperature [any unit]; used up to the liquidus
/// @param liquid  at and above the liquidus [the same unit]
/// @return        against temperature, linear between points at most 2.5 K apart in the mush
inline Curve mixed_by_fraction(const AlloyCard& card, const Curve& solid, double liquid) {
  constexpr double spacing = 2.5;  // [K]
  std::vector<double> at, value;
  const auto add = [&](double t) {
    const double fraction = t >= card.liquidus ? 1.0 : liquid_fraction_at(card, t);
    at.push_back(t);
    value.push_back((1.0 - fraction) * solid(t) + fraction * liquid);
  };
  if (!solid.constant())
    for (const double t : solid.at())
      if (t < card.solidus) add(t);
  if (card.liquidus <= card.solidus) {  // a pure metal: a jump
    constexpr double half_width = 0.01;  // [K]
    at.insert(at.end(), {card.liquidus - half_width, card.liquidus + half_width});
    value.insert(value.end(), {solid(card.liquidus), liquid});
    return Curve(Abscissa::temperature, std::move(at), std::move(value));
  }
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
    const int parts = static_cast<int>(width / spacing) + 1;
    for (int k = 1; k < parts; ++k) add(kinks[i] + width * k / parts);
  }
  return Curve(Abscissa::temperature, std::move(at), std::move(value));
}

/// The coherency temperature that corresponds to a solid fraction [°C]: at 1 the solidus, at 0 the
/// liquidus. @param solid_fraction  [1]
inline double coherency_at(const AlloyCard& card, double solid_fraction) {
  return temperature_of_fraction(card, 1.0 - solid_fraction);
}

}  // namespace dccast::material
