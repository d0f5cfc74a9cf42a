#pragma once

#include "tests/unit/material/paper_card.hpp"

namespace dccast::material::testing {

/// The paper's alloy with a mush that is coherent at 0.9 and grown together at 0.98, and with a
/// yield limit: 100 MPa cold, falling to 20 MPa at 400 °C, hardening below that.
inline AlloyCard mush_card() {
  AlloyCard card = paper_card();
  card.coherency = 622.9;  // 90 % solid
  card.mush = MushLaw{.coalescence = 0.98, .strength_decay = 10.0, .unfed_strain_share = 0.0};
  card.cold_strength =
      ColdStrength{.yield_stress = {Abscissa::temperature, {20, 400}, {100e6, 20e6}},
                   .hardening = {Abscissa::temperature, {300, 400}, {1, 0}}};
  return card;
}

}  // namespace dccast::material::testing
