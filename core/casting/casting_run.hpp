#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/casting/case/case.hpp"
#include "core/casting/case/lever_record.hpp"
#include "core/casting/findings/run_failure.hpp"
#include "core/results/checkpoint_file.hpp"
#include "core/results/frame.hpp"
#include "core/results/step_report.hpp"

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
  /// An accepted step. @return what the run does next
  virtual Order on_step(const results::StepReport& report) = 0;
  /// Reports of steps 1 to `step` of an earlier part of this run, exact, for the result file; fewer
  /// if some are lost. Called before on_resumed().
  virtual std::vector<results::StepReport> reported_steps(std::int64_t /*step*/) { return {}; }
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
  /// A note for people, one line without an end of line.
  virtual void on_message(std::string_view text) = 0;
};

/// Where a run that follows a casting gets its levers from. Called from the thread of the run.
class LeverFeed {
public:
  virtual ~LeverFeed() = default;

  /// What has arrived since the last call, in the order of time; all from the beginning at first.
  struct Arrived {
    std::vector<LeverReading> readings;
    bool closed = false;         ///< no more will come
    Order order = Order::go_on;  ///< what the run does instead of waiting any longer
  };
  /// Waits until there is a reading of a time [s] or later, the record is closed, or the run has to
  /// stop.
  virtual Arrived wait_until(double time) = 0;
};

/// One casting, step by step, in two or three dimensions. Does not read or write result files.
class CastingRun {
public:
  virtual ~CastingRun() = default;

  /// Whether the run has reached the end of its case.
  virtual bool finished() const = 0;
  /// Advances by one accepted step, reducing the time step as often as necessary.
  /// @throws SolveFailed  not converged at the smallest time step
  virtual results::StepReport advance() = 0;
  virtual double time() const = 0;  ///< [s] end of the last accepted step
  /// End of the next step if it converges at once; otherwise it ends earlier [s].
  virtual double next_time() const = 0;
  /// Follows what was measured: the reading replaces the plan up to its time.
  /// @throws std::invalid_argument  the reading is not later than the last one
  virtual void append(const LeverReading& reading) = 0;

  /// Whether the fields at the present time are to be stored.
  virtual bool frame_is_due() const = 0;
  /// The fields at the present time; advances the time of the next frame.
  virtual results::Frame take_frame() = 0;

  /// Records a failure of the last step. Failures are part of the state, so a resumed run keeps
  /// them.
  virtual void fail(RunFailure failure) = 0;
  /// Failures so far that did not end the run, and the one that did.
  virtual const RunFailures& failures() const = 0;
  /// The time from which the model is no longer valid; empty while it is valid.
  virtual const std::optional<results::ValidityLoss>& validity_lost() const = 0;

  /// Findings of the run so far: each code once, in the order in which they were raised.
  virtual const std::vector<results::Finding>& findings() const = 0;
  /// Of each limit that has applied and is one of a figure.
  virtual const std::vector<results::Margin>& margins() const = 0;

  /// The complete state of the run, as stored in a checkpoint.
  virtual results::Sections state_sections() const = 0;
  /// Continues from a stored state of the same case. @pre no step has been made yet
  /// @return  why the state does not belong to this run: a section is missing, an array does not
  ///          fit the mesh, or a time lies outside the case; the run is then unchanged. Empty on
  ///          success.
  [[nodiscard]] virtual std::string restore(const results::Sections& state) = 0;
};

/// Creates the run of a case in the dimension of its section.
/// @param threads  number of threads for a quarter slab; other sections use one
/// @throws InvalidCase  a file of the case cannot be read
std::unique_ptr<CastingRun> make_run(const Case& casting_case, int threads = 1);

}  // namespace dccast::casting
