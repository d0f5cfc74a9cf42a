#pragma once

#include <string>
#include <vector>

namespace dccast::results {

/// The moment from which the figures of a run are no longer an answer (docs/validity.md).
struct ValidityLoss {
  std::string kind;           ///< as the outcome of a run that stops there: SCHEMA.md
  std::string message;        ///< one sentence, with time, place, value, limit and its key
  double time = 0.0;          ///< [s] end of the step that lost it
  std::vector<double> place;  ///< coordinates in the undeformed slab [m]
  double value = 0.0;         ///< in `unit`
  double limit = 0.0;         ///< in `unit`
  std::string unit;           ///< "m", "rad" or "1"
  bool operator==(const ValidityLoss&) const = default;
};

}  // namespace dccast::results
