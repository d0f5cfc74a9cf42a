#pragma once

#include <vector>

#include "core/casting/case.hpp"
#include "core/casting/plausibility/plausibility_state.hpp"
#include "core/casting/plausibility/step_figures.hpp"

/// Whether a casting is one that a plant could run. Every finding is a pure function in a file of
/// its own, listed in one of two tables: of_case.hpp and of_step.hpp. docs/findings.md has them
/// all.
namespace dccast::casting {

/// Findings of a case that follow from its tables alone, each code once.
/// @param casting_case  one without faults
std::vector<Finding> findings_of_case(const Case& casting_case);

/// Findings that a run of the case's heat alone, on a coarse mesh with few steps, would raise:
/// a forecast for who has not run it yet. Milliseconds. A quarter slab is taken by its section
/// through the thickness. Nothing for an imported mesh or temperatures from a file.
std::vector<Finding> forecast(const Case& casting_case);

/// Raises what the figures of a step say and the run has not raised before.
void raise_findings(const Case& casting_case, const StepFigures& step, PlausibilityState& state);

/// Measures a step, writes what it reports into `report`, and raises findings that the run has not
/// raised before.
template <int Dim>
void judge(const Case& casting_case, const StepView<Dim>& view, results::StepReport& report,
           PlausibilityState& state);

extern template void judge(const Case&, const StepView<2>&, results::StepReport&,
                           PlausibilityState&);
extern template void judge(const Case&, const StepView<3>&, results::StepReport&,
                           PlausibilityState&);

}  // namespace dccast::casting
