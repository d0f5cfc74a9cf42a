#pragma once

#include <optional>

#include "core/case/case.hpp"
#include "core/case/course.hpp"
#include "core/results/finding.hpp"

/// Findings that follow from the tables of a case alone; one file per finding. docs/findings.md has
/// their limits, sources and practical meaning.
namespace dccast::casting {

using results::Finding;
using results::Severity;

std::optional<Finding> no_superheat(const Case& casting_case, const Course& course);
std::optional<Finding> coherency_in_liquid(const Case& casting_case, const Course& course);
std::optional<Finding> water_never_meets(const Case& casting_case, const Course& course);
std::optional<Finding> zone_never_meets(const Case& casting_case, const Course& course);
std::optional<Finding> table_never_reached(const Case& casting_case, const Course& course);

}  // namespace dccast::casting
