#pragma once

#include <string>

#include "core/findings/of_step.hpp"
#include "core/findings/run_failure.hpp"
#include "core/findings/sentence.hpp"

namespace dccast::casting {

/// Reports a loss of validity as a finding; the decision itself is made in validity.cpp.
/// @param key      of the case that sets the limit
/// @param meaning  what it means in practice
inline std::optional<Finding> of_validity(const StepFigures& f, FailureKind kind, const char* key,
                                          const std::string& meaning) {
  if (!f.validity_lost || f.validity_lost->kind != name_of(kind)) return std::nullopt;
  const results::ValidityLoss& lost = *f.validity_lost;
  const PlacedFigure figure{lost.value, {lost.place.begin(), lost.place.end()}};
  return finding_of(lost.kind.c_str(), Severity::danger, meaning,
                    {figure, lost.limit, lost.unit.c_str(), key});
}

}  // namespace dccast::casting
