#pragma once

#include <algorithm>
#include <cstddef>

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

/// The coherency temperature that corresponds to a solid fraction [°C]: at 1 the solidus, at 0 the
/// liquidus. @param solid_fraction  [1]
inline double coherency_at(const AlloyCard& card, double solid_fraction) {
  return temperature_of_fraction(card, 1.0 - solid_fraction);
}

}  // namespace dccast::material
