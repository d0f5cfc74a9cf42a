#include "core/findings/of_validity.hpp"

namespace dccast::casting {

std::optional<Finding> shell_melted_through(const Case&, const StepFigures& f) {
  return of_validity(f, FailureKind::shell_melted_through, "validity.minimum_shell",
                     "The shell over the bottom block has melted through: the slab bleeds out, and "
                     "later results are not valid.");
}

}  // namespace dccast::casting
