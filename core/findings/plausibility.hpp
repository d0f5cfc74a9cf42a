#pragma once

#include <vector>

#include "core/case/case.hpp"
#include "core/findings/plausibility_state.hpp"
#include "core/findings/step_figures.hpp"

/// Judges whether a plant could run a casting. Every finding is a pure function in a file of its
/// own, listed in of_case.hpp or of_step.hpp. docs/findings.md describes them all.
namespace dccast::casting {

/// Findings of a case that follow from its tables alone, each code once.
/// @param casting_case  one without faults
std::vector<Finding> findings_of_case(const Case& casting_case);

/// Raises the findings of a step that the run has not raised before.
void raise_findings(const Case& casting_case, const StepFigures& step, PlausibilityState& state);

/// Computes the figures of a step, writes them to `report`, and raises the findings that the run
/// has not raised before.
template <int Dim>
void judge(const Case& casting_case, const StepView<Dim>& view, results::StepReport& report,
           PlausibilityState& state);

extern template void judge(const Case&, const StepView<2>&, results::StepReport&,
                           PlausibilityState&);
extern template void judge(const Case&, const StepView<3>&, results::StepReport&,
                           PlausibilityState&);

}  // namespace dccast::casting
