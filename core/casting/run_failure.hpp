#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace dccast::casting {

/// What went wrong in a run. What each one means for the run is said by ends_run().
enum class FailureKind {
  solve_failed,          ///< a step did not converge at the smallest time step
  check_failed,          ///< energy, weight or contact conditions off by more than their bound
  shell_melted_through,  ///< no solid path from a symmetry plane to a face
  motion_too_large,      ///< rotation or slip beyond what small strains hold
  liquid_pressure_lost,  ///< the fictitious liquid no longer carries its hydrostatic pressure
  storage,               ///< a file of the run could not be written or read
  other_version,         ///< the checkpoint is of another version of the solver
};

/// The name of a kind in results.h5 and in checkpoints, e.g. "solve_failed".
std::string name_of(FailureKind kind);
/// The kind of that name; nothing when there is none.
std::optional<FailureKind> failure_kind(std::string_view name);

/// Whether a run ends at once with such a failure; else it goes on and has failed at its end.
bool ends_run(FailureKind kind);

struct RunFailure {
  FailureKind kind = FailureKind::solve_failed;
  std::string message;
  double time = 0.0;                     ///< [s]
  double time_step = 0.0;                ///< [s]
  std::vector<double> place;             ///< in the undeformed slab [m]; empty where there is none
  std::vector<double> residual_history;  ///< [1] of the last attempt; of solve_failed only
  bool operator==(const RunFailure&) const = default;
};

/// What went wrong, in its order: the first one is the cause.
using RunFailures = std::vector<RunFailure>;

/// Lists a failure behind the others, once per kind: a check that fails in one step fails in the
/// next ones too.
void add_failure(RunFailures& failures, RunFailure failure);

/// The cause and what followed it: "CAUSE; then KIND: MESSAGE"; empty without a failure.
std::string in_words(const RunFailures& failures);

enum class RunEnd {
  succeeded,
  failed,         ///< `failures` says why
  stopped,        ///< by order, at a checkpoint
  cancelled,      ///< by order
  other_version,  ///< not begun: the checkpoint is of another version, and the run was to wait
};

struct RunOutcome {
  RunEnd end = RunEnd::succeeded;
  RunFailures failures;  ///< the first one is the cause; empty unless failed or other_version
};

}  // namespace dccast::casting
