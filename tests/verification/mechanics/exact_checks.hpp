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

}  // namespace dccast::verification
