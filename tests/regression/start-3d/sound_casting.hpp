#pragma once

#include "tests/regression/whole_run.hpp"

namespace dccast::regression {

/// Heat, weight, contact and equilibrium of every step of a quarter slab that casts to its end.
/// Tolerances are those of the case: 1e-6 of the forces that act, a thousandth of the weight.
inline void expect_sound_casting(const std::vector<results::StepReport>& reports) {
  for (const auto& r : reports) {
    EXPECT_LE(std::abs(r.energy_balance_error), 1e-10) << "t = " << r.time;
    EXPECT_NEAR(r.bottom_reaction, r.weight, 1e-3 * r.weight) << "t = " << r.time;
    EXPECT_LE(r.complementarity_error, 1e-6) << "t = " << r.time;
    EXPECT_LE(r.equilibrium_residual, 1e-6) << "t = " << r.time;
    EXPECT_FALSE(r.beyond_validity) << "t = " << r.time;
  }
}

inline double end_lift_mm(const std::vector<results::StepReport>& reports, std::size_t monitor) {
  return 1e3 * reports.back().monitor_displacement.at(monitor).at(2);
}

}  // namespace dccast::regression
