#pragma once

#include <optional>

#include "core/casting/case.hpp"
#include "core/casting/plausibility/course.hpp"
#include "core/results/finding.hpp"

/// Findings of a case that follow from its tables alone; a file each. Limits, sources and what each
/// means in the pit: docs/findings.md.
namespace dccast::casting {

using results::Finding;
using results::Severity;

std::optional<Finding> no_superheat(const Case& casting_case, const Course& course);
std::optional<Finding> coherency_in_liquid(const Case& casting_case, const Course& course);
std::optional<Finding> water_never_meets(const Case& casting_case, const Course& course);
std::optional<Finding> zone_never_meets(const Case& casting_case, const Course& course);
std::optional<Finding> table_never_reached(const Case& casting_case, const Course& course);

}  // namespace dccast::casting
