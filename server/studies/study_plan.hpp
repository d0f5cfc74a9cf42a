#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/study.pb.h"
#include "proto/frames/contraction.hpp"

namespace dccast::studies {

/// One run of a plan, before it is a job.
struct PlannedRun {
  std::string key;   ///< names the run in request ids; the same however often the plan is made
  std::string name;  ///< for people: "refinement 4"
  v1::Case description;
  std::vector<v1::CaseChange> changes;  ///< already made in `description`
};

/// The curl of one run: the vertical displacement of every monitor.
struct RunHistory {
  std::vector<v1::CurlCurve> curves;    ///< by monitor, all at the instants of the run's steps
  std::optional<double> beyond_from_s;  ///< first step at which the model was no longer valid

  /// [degC] by monitor, at the same instants; NaN where it is not reported.
  std::map<std::string, std::vector<double>> temperature_c;

  const v1::CurlCurve* curve(const std::string& monitor) const;  ///< null: not reported
};

/// The wide face of a quarter slab where its casting is steady, and the section it was cast in.
struct RunFace {
  v1::Section section;
  frames::SteadyFace steady;
};

/// A run as it stands, for evaluation.
struct EvaluatedRun {
  v1::StudyRun run{};
  int number = 0;                 ///< in the plan, from 0
  RunHistory history{};           ///< of a run that succeeded, where the plan asks for histories
  std::optional<RunFace> face{};  ///< of a run that succeeded, where the plan grows
  std::string face_fault{};       ///< why it cannot be read

  bool succeeded() const { return run.state() == v1::SUCCEEDED; }
  /// Whether it can be learned from: a run beyond validity is no answer.
  bool counts() const {
    return succeeded() && !run.beyond_validity() && !history.curves.empty() &&
           history.curves.front().time_s_size() > 0;
  }
};

/// The history in the steps of a job.
RunHistory run_history(const v1::Job& job, const std::vector<v1::StepReport>& steps);

/// Figures of a curve, one of its fields, at other instants; NaN outside its time.
std::vector<double> at_instants(const std::vector<double>& instants_s, const v1::CurlCurve& curve,
                                const google::protobuf::RepeatedField<double>& figures);

/// Whether the same case would end in the same way again.
bool by_the_case_itself(const v1::Failure& failure);

/// What the runs of a study are, and their results together. One implementation for each kind.
class StudyPlan {
public:
  virtual ~StudyPlan() = default;
  /// Those that are laid out beforehand.
  virtual int runs() const = 0;
  /// @param number  from 0, of these
  virtual PlannedRun run(int number) const = 0;
  /// That of any run, also one that is not laid out yet.
  virtual std::string key(int number) const { return std::to_string(number + 1); }
  /// A plan grows when it may have more runs than it lays out: each follows from those before it.
  virtual int most_runs() const { return runs(); }
  bool grows() const { return most_runs() > runs(); }
  /// The runs that decide what a further one is have lower numbers than this; it waits for their
  /// end.
  virtual int rests_on(int number) const { return number; }
  /// Whether next() is asked after runs that have failed, or the plan ends with them.
  virtual bool outlasts_failures() const { return false; }
  /// Whether next() and evaluate() need the faces of the runs that succeeded.
  virtual bool needs_faces() const { return false; }
  /// A run that is not laid out, nothing when those before it suffice.
  /// @param before  those it rests on, ended; without those whose job was deleted
  virtual std::optional<PlannedRun> next(int /*number*/,
                                         const std::vector<EvaluatedRun>& /*before*/) const {
    return std::nullopt;
  }
  /// Writes into a run of the answer what is particular to the plan: refinement, values.
  virtual void describe(int /*number*/, v1::StudyRun& /*run*/) const {}
  /// Whether evaluate() needs the histories of the runs that succeeded.
  virtual bool needs_histories() const { return false; }
  /// Adds the results of the runs together. @param runs  in the order of the plan
  virtual void evaluate(const std::vector<EvaluatedRun>& /*runs*/,
                        v1::StudyResult& /*result*/) const {}

protected:
  /// A case with changes.
  PlannedRun planned(int number, std::string name, const v1::Case& base,
                     std::vector<v1::CaseChange> changes) const;
};

/// What is wrong with a plan before any of its runs is looked at: number and kind of its figures,
/// keys and values of its axes.
std::vector<v1::Fault> plan_faults(const v1::CreateStudyRequest& request);

/// The plan of a request without plan_faults(). The same request gives the same runs.
std::unique_ptr<StudyPlan> study_plan(const v1::CreateStudyRequest& request);

// The kinds of plans. A further kind is a file with these two functions, and its line in
// study_plan.cpp.

std::vector<v1::Fault> refinement_faults(const v1::CreateStudyRequest& request);
std::unique_ptr<StudyPlan> refinement_plan(const v1::CreateStudyRequest& request);

std::vector<v1::Fault> sweep_faults(const v1::CreateStudyRequest& request);
std::unique_ptr<StudyPlan> sweep_plan(const v1::CreateStudyRequest& request);

std::vector<v1::Fault> recipe_faults(const v1::CreateStudyRequest& request);
std::unique_ptr<StudyPlan> recipe_plan(const v1::CreateStudyRequest& request);

std::vector<v1::Fault> mould_faults(const v1::CreateStudyRequest& request);
std::unique_ptr<StudyPlan> mould_plan(const v1::CreateStudyRequest& request);

// What plans and those who evaluate them share; of values and their texts in sweep_plan.cpp.

/// The number that a value of a key stands for, in the unit of the schema; NaN for what is none.
double number_of(const v1::Case& base, const std::string& key, const std::string& value);

/// A value between two of a key, as in a case file, in the unit of the first one.
/// @param place  0 to 1
std::string value_between(const v1::Case& base, const std::string& key, const std::string& low,
                          const std::string& high, double place);

/// What mesh and time steps leave uncertain of a curl, relative to it; nothing where it is not
/// known.
/// @param description  case as submitted
std::optional<double> relative_curl_error(v1::Case description);

}  // namespace dccast::studies
