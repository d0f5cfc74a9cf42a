#pragma once

#include <optional>
#include <vector>

#include "core/casting/case/case.hpp"
#include "core/casting/findings/figures.hpp"
#include "core/casting/findings/run_failure.hpp"
#include "core/results/checkpoint_file.hpp"
#include "core/results/step_report.hpp"

/// The judge of a run: all findings of a step follow from its figures and the table of rules.
namespace dccast::casting {

using results::Finding;
using results::Margin;
using results::Severity;
using results::ValidityLoss;

/// Findings so far, and the history that the judgement of further steps needs; a part of RunState.
struct FindingsState {
  std::vector<Finding> raised;       ///< each code once, in the order in which they were raised
  std::optional<ValidityLoss> lost;  ///< the first loss of validity
  std::vector<Margin> margins;       ///< of each rule that has applied and compares with a limit
  FigureHistory history;
};

/// Findings of a case that follow from its tables alone, each code once.
/// @param casting_case  a case without faults
std::vector<Finding> findings_of_case(const Case& casting_case);

/// Judges a step by every rule: raises findings, updates the worst exceedance of those raised
/// before and the margins, and records the first loss of validity.
/// @return  the failures that follow from findings raised in this step
RunFailures judge(const Case& casting_case, const StepFigures& step, FindingsState& state);

/// Converts the state to sections of a checkpoint, and back.
void write_findings(const FindingsState& state, results::Sections& sections);
/// @throws std::out_of_range  a section is missing, names an unknown severity or a number has
///                            several values
FindingsState read_findings(const results::Sections& sections);

}  // namespace dccast::casting
