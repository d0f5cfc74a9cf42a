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

/// A plate in plane strain bent by end moments, its cells 1 to 10 times longer than it is thick:
/// the largest error of the deflection against beam theory, with four layers of cells at Poisson's
/// ratio 0.3 and with one layer at 0.4999.
Result run_plate(const TestRun& run);

/// Deformations of one skewed cell without energy, which must be the three of a rigid body, and the
/// stiffness of its softest other one over that of its stiffest, at Poisson's ratio 0.3.
Result run_modes(const TestRun& run);

/// Patch test of an axisymmetric body: uniform strain across, around and along the axis on a
/// distorted mesh that reaches the axis.
Result run_axisymmetric_patch(const TestRun& run);

/// Thick-walled tube under inner pressure in plane strain along its axis (Timoshenko): displacement
/// and stress, their orders against cells twice as large, and errors at Poisson's ratio 0.4999.
Result run_tube(const TestRun& run);

/// The same tube creeping steadily (Odqvist): with Norton's order n the stress across is
/// -p ((b/r)^(2/n) - 1) / ((b/a)^(2/n) - 1), whatever its elasticity. Errors of the stress and of
/// the rate of the inner wall.
Result run_tube_creep(const TestRun& run);

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
