#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dccast/v1/study.pb.h"
#include "server/studies/run_history.hpp"

namespace dccast::studies {

/// One run of a plan, before it is a job.
struct PlannedRun {
  std::string key;   ///< names the run in request ids; the same however often the plan is made
  std::string name;  ///< for people: "refinement 4"
  v1::Case description;
  std::vector<v1::CaseChange> changes;  ///< already made in `description`
};

/// A run as it stands, for evaluation.
struct EvaluatedRun {
  v1::StudyRun run;
  RunHistory history;  ///< of a run that succeeded, where the plan asks for histories

  bool succeeded() const { return run.state() == v1::SUCCEEDED; }
};

/// What the runs of a study are, and what they say together. One implementation for each kind.
class StudyPlan {
public:
  virtual ~StudyPlan() = default;
  virtual int runs() const = 0;
  /// @param number  from 0
  virtual PlannedRun run(int number) const = 0;
  /// Writes into a run of the answer what is particular to the plan: refinement, values.
  virtual void describe(int number, v1::StudyRun& run) const = 0;
  /// Whether evaluate() needs the histories of the runs that succeeded.
  virtual bool needs_histories() const { return false; }
  /// Adds what the runs say together. @param runs  in the order of the plan
  virtual void evaluate(const std::vector<EvaluatedRun>& runs, v1::StudyResult& result) const;
};

/// What is wrong with a plan before any of its runs is looked at: number and kind of its figures,
/// keys and values of its axes.
std::vector<v1::Fault> plan_faults(const v1::CreateStudyRequest& request);

/// The plan of a request without plan_faults(). The same request gives the same runs.
std::unique_ptr<StudyPlan> study_plan(const v1::CreateStudyRequest& request);

}  // namespace dccast::studies
