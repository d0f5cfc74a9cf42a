#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace dccast::casting {

/// Kinds of failure of a run. ends_run() says which of them end the run at once.
enum class FailureKind {
  solve_failed,  ///< a step did not converge at the smallest time step
  check_failed,  ///< energy balance, weight or contact conditions violated beyond their bound
  shell_melted_through,  ///< no solid path from a symmetry plane to a face
  motion_too_large,      ///< rotation or slip beyond the limit of small strains
  storage,               ///< a file of the run could not be written or read
  other_version,         ///< the checkpoint was written by another version of the solver
};

/// The name of a kind in results.h5 and in checkpoints, e.g. "solve_failed".
std::string name_of(FailureKind kind);
/// The kind with a name; empty if there is none.
std::optional<FailureKind> failure_kind(std::string_view name);

/// Whether a run ends at once with a failure of this kind. Otherwise it continues to its end and
/// counts as failed.
bool ends_run(FailureKind kind);

/// A failure of a run: what, when and where.
struct RunFailure {
  FailureKind kind = FailureKind::solve_failed;
  std::string message;
  double time = 0.0;          ///< [s]
  double time_step = 0.0;     ///< [s]
  std::vector<double> place;  ///< in the undeformed slab [m]; empty if the failure has no place
  std::vector<double> residual_history;  ///< [1] of the last attempt; for solve_failed only
  std::string finding{};  ///< code of the finding that it follows from; empty if from none
  bool operator==(const RunFailure&) const = default;
};

/// Failures in the order in which they occurred: the first one is the cause.
using RunFailures = std::vector<RunFailure>;

/// Appends a failure unless there is one of its kind: a check that fails in one step usually fails
/// in the next ones too.
void add_failure(RunFailures& failures, RunFailure failure);

/// The cause and the failures that followed: "CAUSE; then KIND: MESSAGE"; empty without a failure.
std::string in_words(const RunFailures& failures);

/// How a run ended.
enum class RunEnd {
  succeeded,
  failed,         ///< `failures` has the causes
  stopped,        ///< on request, at a checkpoint
  cancelled,      ///< on request
  other_version,  ///< not started: the checkpoint has another version, and OtherVersion::wait is
                  ///< set
};

/// The end of a run with its failures.
struct [[nodiscard]] RunOutcome {
  RunEnd end = RunEnd::succeeded;
  RunFailures failures;  ///< the first one is the cause; empty unless failed or other_version
};

}  // namespace dccast::casting
