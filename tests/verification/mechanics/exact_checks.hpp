#pragma once

#include "tests/verification/mechanics/paper_tests.hpp"

namespace dccast::verification {

/// Patch test: a linear displacement given on the boundary of a distorted mesh, with a linearised
/// rotation in it; errors are round-off for an element that passes.
Result run_patch(const TestRun& run);

/// Creep under constant load (plane strain, pure deviator): the strain rate is constant, which
/// backward Euler follows exactly.
Result run_creep(const TestRun& run);

/// Relaxation of a held strain: d|s|/dt = -2 mu kappa |s|^(q-1) has a closed form; first order in
/// dt.
Result run_relaxation(const TestRun& run);

/// A free strip whose temperature varies linearly through its thickness bows without stress in its
/// plane: u2 = (1 + nu) k x2 x3, u3 = (1 + nu) k (x3^2 - x2^2) / 2 with thermal strain k x3.
Result run_bowed_strip(const TestRun& run);

/// Hertz's contact: a block on a rigid cylinder, its other sides under the stresses of a point
/// force in a half-plane. Errors of displacement and stress in the block, of half width (in cells),
/// peak and distribution of the pressure, of the load; `finite_body_error` is what those sides do
/// to the pressure.
Result run_hertz(const TestRun& run);
/// gamma_c of sbm that suits it [Pa/m]: the block's modulus over three half widths of the contact;
/// a third or three times of it takes twice the iterations.
inline constexpr double hertz_gamma_c = 1e10;

/// The same pressed and let go in steps, so that pairs close and open: the largest errors of all
/// steps, and the difference between the first and the last, which have the same load.
Result run_hertz_cycle(const TestRun& run);

}  // namespace dccast::verification
