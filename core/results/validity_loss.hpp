#pragma once

#include <string>
#include <vector>

namespace dccast::results {

/// The time from which the results of a run are no longer valid (docs/validity.md).
struct ValidityLoss {
  std::string kind;  ///< the same words as for the outcome of a run that stops there, see SCHEMA.md
  std::string message;        ///< one sentence, with time, place, value, limit and its key
  double time = 0.0;          ///< [s] end of the step in which validity was lost
  std::vector<double> place;  ///< coordinates in the undeformed slab [m]
  double value = 0.0;         ///< [`unit`]
  double limit = 0.0;         ///< [`unit`]
  std::string unit;           ///< "m", "rad" or "1"
  bool operator==(const ValidityLoss&) const = default;
};

}  // namespace dccast::results
