#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "core/results/finding.hpp"
#include "core/results/step_report.hpp"
#include "core/results/validity_loss.hpp"

namespace dccast::casting {

/// Answer of an observer: what the run does after a step.
enum class Order {
  go_on,
  stop_at_checkpoint,  ///< write a checkpoint and stop; the run can be resumed
  cancel,              ///< stop without a checkpoint
};

/// Receives every accepted step, keeps it, and decides whether the run continues. Called from the
/// thread of the run.
class StepObserver {
public:
  virtual ~StepObserver() = default;
  virtual Order on_step(const results::StepReport& report) = 0;
  /// The reports of the steps from 1 to this one of an earlier part of this run, exact, from which its results
  /// are made; fewer if some are lost. Called before on_resumed().
  virtual std::vector<results::StepReport> reported_steps(std::int64_t) { return {}; }
  /// Waits until all that was reported is on the disk: a checkpoint follows. Called from another
  /// thread. @throws std::system_error
  virtual void sync_reports() {}
  /// The run continues from a checkpoint: steps after `step`, at `time` [s], are reported (again).
  virtual void on_resumed(std::int64_t step, double time) = 0;
  /// The model is no longer valid: the next reported step and all later ones are marked. Called
  /// once, and again after a resumption. The step reports carry the mark too.
  virtual void on_validity_lost(const results::ValidityLoss&) {}
  /// A finding about the casting: findings of the case before the first step, findings of a step
  /// before its report. One comes again at the end of the run if its worst exceedance has grown
  /// since; all come again after a resumption. The last one of a code holds.
  virtual void on_finding(const results::Finding&) {}
  virtual void on_message(std::string_view text) = 0;
};

}  // namespace dccast::casting
