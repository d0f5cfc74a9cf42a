#pragma once

#include <optional>

#include "core/findings/step_figures.hpp"
#include "core/results/finding.hpp"

/// Findings of an accepted step; one file per finding. The caller sets their time. docs/findings.md
/// has their limits, sources and practical meaning.
namespace dccast::casting {

using results::Finding;
using results::Severity;

std::optional<Finding> bleed_out_at_exit(const Case& casting_case, const StepFigures& step);
std::optional<Finding> remelting_in_gap(const Case& casting_case, const StepFigures& step);
std::optional<Finding> bleed_out_at_bottom(const Case& casting_case, const StepFigures& step);
std::optional<Finding> bottom_shell_open(const Case& casting_case, const StepFigures& step);
std::optional<Finding> bottom_shell_fails(const Case& casting_case, const StepFigures& step);
std::optional<Finding> sump_too_deep(const Case& casting_case, const StepFigures& step);
std::optional<Finding> shell_melted_through(const Case& casting_case, const StepFigures& step);
std::optional<Finding> slip_too_large(const Case& casting_case, const StepFigures& step);
std::optional<Finding> rotation_too_large(const Case& casting_case, const StepFigures& step);
std::optional<Finding> lift_too_large(const Case& casting_case, const StepFigures& step);
std::optional<Finding> liquid_pressure_lost(const Case& casting_case, const StepFigures& step);
std::optional<Finding> hot_tears(const Case& casting_case, const StepFigures& step);
std::optional<Finding> curl_outside_band(const Case& casting_case, const StepFigures& step);

}  // namespace dccast::casting
