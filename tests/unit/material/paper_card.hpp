#pragma once

#include "core/material/alloy_card.hpp"

namespace dccast::material::testing {

/// The mechanical data of the paper's alloy, Tables 9 and 10 and eq. (11), as printed.
inline AlloyCard paper_card() {
  AlloyCard card;
  card.name = "paper";
  card.liquidus = card.coherency = 649.0;
  card.solidus = 620.0;
  card.density = {Abscissa::temperature, {0, 620, 649}, {2700, 2557.4, 2360}};
  card.young_modulus = {Abscissa::temperature, {126.9, 326.9, 526.9}, {67e9, 58e9, 40e9}};
  card.poisson_ratio = {Abscissa::temperature, {126.9, 326.9, 526.9}, {0.3134, 0.3448, 0.45}};
  card.creep = NortonHoffConstants{4.0e12, 15.72e6, 37.3 * 4184.0, 6.0};
  return card;
}

}  // namespace dccast::material::testing
