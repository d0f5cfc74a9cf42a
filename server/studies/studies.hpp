#pragma once

#include "server/studies/run_results.hpp"
#include "server/studies/studies_state.hpp"
#include "server/studies/study_evaluation.hpp"
#include "server/studies/study_feeder.hpp"
#include "server/studies/study_requests.hpp"
#include "server/studies/sweep_surfaces.hpp"

namespace dccast::studies {

/// Studies: each is a plan in the store, and a feeder queues its runs as jobs, a few at a time.
/// This class owns the parts, connects them to the scheduler, and starts and stops their threads.
class Studies {
public:
  /// @param store, scheduler, intake  outlive this object
  Studies(StudyOptions options, StudyStore& store, jobs::Scheduler& scheduler,
          const intake::CaseIntake& intake);
  /// As stop().
  ~Studies();

  /// Starts to queue runs and to build surfaces; after StudyRequests::recover().
  void start();
  /// Stops both, and stops waking watchers about changes of jobs.
  void stop();

  /// The parts that callers use.
  StudyRequests& requests() { return requests_; }
  StudyEvaluation& evaluation() { return evaluation_; }
  SweepSurfaces& surfaces() { return surfaces_; }
  StudyNotifier& notifier() { return state_.notifier; }

private:
  StudiesState state_;
  RunResults results_;
  SweepSurfaces surfaces_;
  StudyFeeder feeder_;
  StudyRequests requests_;
  StudyEvaluation evaluation_;
};

}  // namespace dccast::studies
