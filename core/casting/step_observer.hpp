#pragma once

#include <string_view>

#include "core/results/finding.hpp"
#include "core/results/step_report.hpp"
#include "core/results/validity_loss.hpp"

namespace dccast::casting {

/// What the run does after a step.
enum class Order {
  go_on,
  stop_at_checkpoint,  ///< write a checkpoint and leave; the run can be resumed
  cancel,              ///< leave
};

/// Sees every accepted step and decides whether the run goes on. Called from the thread of the run.
class StepObserver {
public:
  virtual ~StepObserver() = default;
  virtual Order on_step(const results::StepReport& report) = 0;
  /// A step up to the checkpoint, whose report was lost on its way:
  /// RunDirectory::last_reported_step. Comes before on_resumed(), is exact, and is stored already.
  virtual void on_missed_step(const results::StepReport&) {}
  /// The run went on from a checkpoint; steps after `step`, at `time` [s], are reported (again).
  virtual void on_resumed(std::int64_t step, double time) = 0;
  /// The model is no longer valid: the step reported next and all later ones are marked. Called
  /// once, and again after a resumption. The marks are in the steps too.
  virtual void on_validity_lost(const results::ValidityLoss&) {}
  /// Something about the casting that an engineer should know: each code once, those of the case
  /// before the first step, those of a step before its report. All again after a resumption.
  virtual void on_finding(const results::Finding&) {}
  virtual void on_message(std::string_view text) = 0;
};

}  // namespace dccast::casting
