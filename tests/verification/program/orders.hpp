#pragma once

#include "tests/verification/program/run_request.hpp"

namespace dccast::verification {

/// Orders observed between the last two of three refinements, as figures `order_...`.
Result run_orders(const RunRequest& request);

/// Errors of Hertz's contact on cells halved three times, and the mean orders observed.
Result run_hertz_orders(const RunRequest& request);

/// Displacements by every algorithm at a relative residual of 1e-10: figures `largest_difference`
/// (of T4) and `largest_difference_hertz`, relative, against newton's.
Result run_agreement(const RunRequest& request);

/// Errors against size, for plots: cell [m] or step [s], displacement, stress.
struct Refinement {
  double size, displacement, stress;
};
std::vector<Refinement> refine_t1(mesh::ElementKind element);
std::vector<Refinement> refine_t4();

}  // namespace dccast::verification
