#pragma once

#include <climits>
#include <memory>
#include <string>
#include <vector>

#include "server/jobs/recent.hpp"
#include "server/studies/studies_state.hpp"

namespace dccast::studies {

/// Holds the curls of castings that ended once they had settled (`time.settled`) up to the end of
/// the longest, so that all runs of a study are compared at all lengths. Castings that cool down go
/// on by themselves.
/// @param runs  with their histories
void hold_settled(const v1::Case& description, std::vector<EvaluatedRun>& runs);

/// Results of the runs of studies: curves from the event logs of their jobs, faces of the slab from
/// the last frames. What cannot change any more is kept. Safe to use from several threads.
class RunResults {
public:
  explicit RunResults(StudiesState& state) : state_(state) {}

  /// What is read of each run.
  struct Depth {
    bool histories = false;
    bool faces = false;
    int before = INT_MAX;  ///< only runs with a lower number
  };
  /// Runs of a study with the results that `depth` asks for. Runs of deleted jobs are omitted.
  /// @throws jobs::WorkerDidNotAnswer  no worker can be started to read a face
  std::vector<EvaluatedRun> evaluated_runs(const StudyRecord& study, const Depth& depth);
  /// Forgets the results of a job that was removed.
  void forget(const std::string& job);

private:
  /// Curves of a job, from its event log or kept from before.
  RunCurves history_of(const v1::Job& job);
  /// Contour of the wide face of a run, from its last frame; kept after the first call.
  /// @throws jobs::WorkerDidNotAnswer, jobs::UnsoundResult, frames::NoContraction
  std::shared_ptr<const RunFace> face_of(const v1::Job& job);
  /// Adds the face of a job to a run, or the reason why it has none.
  void add_face(const v1::Job& job, EvaluatedRun& run);

  StudiesState& state_;
  jobs::Recent<const RunCurves> histories_{128'000'000};  ///< by job that has ended; bytes
  jobs::Recent<const RunFace> faces_{4096};               ///< by job that succeeded
};

}  // namespace dccast::studies
