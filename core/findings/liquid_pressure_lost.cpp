#include "core/findings/of_validity.hpp"

namespace dccast::casting {

std::optional<Finding> liquid_pressure_lost(const Case&, const StepFigures& f) {
  return of_validity(f, FailureKind::liquid_pressure_lost, "validity.maximum_liquid_pressure_error",
                     "The pressure of the melt on the shell is not that of its depth: the shell "
                     "has moved away from it, and later results are not valid.");
}

}  // namespace dccast::casting
