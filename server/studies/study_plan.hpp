#pragma once

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "dccast/v1/study.pb.h"
#include "proto/frames/contraction.hpp"
#include "server/studies/run_curves.hpp"

namespace dccast::studies {

/// No prediction or calibration is possible: not a sweep, or too few runs. The text gives the
/// remedy.
struct CannotPredict : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// One run of a plan, before it becomes a job.
struct PlannedRun {
  std::string key;   ///< names the run in request ids; does not depend on when the plan is made
  std::string name;  ///< for messages: "refinement 4"
  v1::Case description;
  std::vector<v1::CaseChange> changes;  ///< already applied to `description`
};

/// Wide face of a quarter slab where its casting is steady, and the section in which it was cast.
struct RunFace {
  /// Section of the case, and the face where its casting is steady.
  v1::Section section;
  frames::SteadyFace steady;
};

/// Current state of a run, for evaluation.
struct EvaluatedRun {
  v1::StudyRun run{};
  int number = 0;                 ///< in the plan, from 0
  RunCurves history{};            ///< set if the run succeeded and the plan needs histories
  std::optional<RunFace> face{};  ///< set if the run succeeded and the plan needs faces
  std::string face_fault{};       ///< reason why the face cannot be read

  bool succeeded() const { return run.state() == v1::SUCCEEDED; }
  /// Whether the run is usable: one beyond validity is not.
  bool counts() const {
    return succeeded() && !run.beyond_validity() && !history.curves.empty() &&
           history.curves.front().time_s_size() > 0;
  }
};

/// Whether the same case would fail in the same way again.
bool by_the_case_itself(const v1::Finding& failure);

/// The runs of a study, and the evaluation of their results. One implementation for each kind.
class StudyPlan {
public:
  /// Plans are made once for a study and then only read.
  virtual ~StudyPlan() = default;
  /// Number of runs that are planned in advance.
  virtual int runs() const = 0;
  /// Run that is planned in advance. @param number  from 0
  virtual PlannedRun run(int number) const = 0;
  /// Key of any run, even one that is not planned yet.
  virtual std::string key(int number) const { return std::to_string(number + 1); }
  /// Most runs. A plan grows if these are more than runs(): later runs depend on earlier results.
  virtual int most_runs() const { return runs(); }
  bool grows() const { return most_runs() > runs(); }
  /// A further run depends on all runs with lower numbers than this, and waits for their end.
  virtual int rests_on(int number) const { return number; }
  /// Whether next() is called after failed runs, too; otherwise the plan ends with them.
  virtual bool outlasts_failures() const { return false; }
  /// Whether next() and evaluate() need the faces of the runs that succeeded.
  virtual bool needs_faces() const { return false; }
  /// Plans a further run; empty if the earlier ones suffice.
  /// @param before  ended runs on which it depends, without those whose job was deleted
  virtual std::optional<PlannedRun> next(int /*number*/,
                                         const std::vector<EvaluatedRun>& /*before*/) const {
    return std::nullopt;
  }
  /// Adds to a run of the answer what this kind of plan has: refinement, values.
  virtual void describe(int /*number*/, v1::StudyRun& /*run*/) const {}
  /// Whether evaluate() needs the histories of the runs that succeeded.
  virtual bool needs_histories() const { return false; }
  /// Evaluates the runs together. @param runs  in the order of the plan
  virtual void evaluate(const std::vector<EvaluatedRun>& /*runs*/,
                        v1::StudyResult& /*result*/) const {}

protected:
  /// A case with changes.
  PlannedRun planned(int number, std::string name, const v1::Case& base,
                     std::vector<v1::CaseChange> changes) const;
};

/// Faults of a plan that can be found without its runs: number and kind of its figures, keys and
/// values of its axes.
std::vector<v1::Fault> plan_faults(const v1::CreateStudyRequest& request);

/// The plan of a request without plan_faults(). The same request gives the same runs.
std::unique_ptr<StudyPlan> study_plan(const v1::CreateStudyRequest& request);

// The kinds of plans. A new kind is a file with these two functions, and a line in study_plan.cpp.

/// Faults and plan of each kind of study. A plan needs a request without faults.
std::vector<v1::Fault> refinement_faults(const v1::CreateStudyRequest& request);
std::unique_ptr<StudyPlan> refinement_plan(const v1::CreateStudyRequest& request);

std::vector<v1::Fault> sweep_faults(const v1::CreateStudyRequest& request);
std::unique_ptr<StudyPlan> sweep_plan(const v1::CreateStudyRequest& request);

std::vector<v1::Fault> recipe_faults(const v1::CreateStudyRequest& request);
std::unique_ptr<StudyPlan> recipe_plan(const v1::CreateStudyRequest& request);

std::vector<v1::Fault> remedy_faults(const v1::CreateStudyRequest& request);
std::unique_ptr<StudyPlan> remedy_plan(const v1::CreateStudyRequest& request);

std::unique_ptr<StudyPlan> levers_plan(const v1::CreateStudyRequest& request);

std::vector<v1::Fault> mould_faults(const v1::CreateStudyRequest& request);
std::unique_ptr<StudyPlan> mould_plan(const v1::CreateStudyRequest& request);

// Functions for plans and their evaluation. Those on values and their texts are in sweep_plan.cpp.

/// Number that a value of a key stands for, in the unit of the schema; NaN if it is not a number.
double number_of(const v1::Case& base, const std::string& key, const std::string& value);

/// Value between two values of a key, as text for a case file, in the unit of the first one.
/// @param place  0 to 1
std::string value_between(const v1::Case& base, const std::string& key, const std::string& low,
                          const std::string& high, double place);

/// Error of a curl due to mesh and time steps; empty if unknown.
/// @param description  case as submitted
std::optional<v1::RelativeError> mesh_error(v1::Case description);

}  // namespace dccast::studies
