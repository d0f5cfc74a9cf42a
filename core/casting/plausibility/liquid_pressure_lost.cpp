#include "core/casting/plausibility/of_validity.hpp"

namespace dccast::casting {

std::optional<Finding> liquid_pressure_lost(const Case&, const StepFigures& f) {
  return of_validity(f, FailureKind::liquid_pressure_lost, "validity.maximum_liquid_pressure_error",
                     "The melt presses on its shell otherwise than its depth says: the shell has "
                     "moved away from it, and nothing after that is an answer.");
}

}  // namespace dccast::casting
