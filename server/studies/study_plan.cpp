#include "server/studies/study_plan.hpp"

#include <stdexcept>

namespace dccast::studies {

namespace {

v1::Fault no_plan(const std::string& message) {
  v1::Fault fault;
  fault.set_field("plan");
  fault.set_message(message);
  fault.set_permitted("refinement, sweep, mould, recipe");
  fault.set_remedy("give one of them");
  return fault;
}

}  // namespace

bool by_the_case_itself(const v1::Failure& failure) {
  switch (failure.kind()) {
    case v1::Failure::SOLVE_FAILED:
    case v1::Failure::CHECK_FAILED:
    case v1::Failure::INVALID_CASE:
    case v1::Failure::SHELL_MELTED_THROUGH:
    case v1::Failure::MOTION_TOO_LARGE:
    case v1::Failure::LIQUID_PRESSURE_LOST:
      return true;
    default:
      return false;
  }
}

std::optional<PlannedRun> StudyPlan::next(int, const std::vector<EvaluatedRun>&) const {
  return std::nullopt;
}

void StudyPlan::evaluate(const std::vector<EvaluatedRun>&, v1::StudyResult&) const {}

std::vector<v1::Fault> plan_faults(const v1::CreateStudyRequest& request) {
  switch (request.plan_case()) {
    case v1::CreateStudyRequest::kRefinement:
      return refinement_faults(request);
    case v1::CreateStudyRequest::kSweep:
      return sweep_faults(request);
    case v1::CreateStudyRequest::kMould:
      return mould_faults(request);
    case v1::CreateStudyRequest::kRecipe:
      return recipe_faults(request);
    case v1::CreateStudyRequest::PLAN_NOT_SET:
      break;
  }
  return {no_plan("a study needs a plan")};
}

std::unique_ptr<StudyPlan> study_plan(const v1::CreateStudyRequest& request) {
  switch (request.plan_case()) {
    case v1::CreateStudyRequest::kRefinement:
      return refinement_plan(request);
    case v1::CreateStudyRequest::kSweep:
      return sweep_plan(request);
    case v1::CreateStudyRequest::kMould:
      return mould_plan(request);
    case v1::CreateStudyRequest::kRecipe:
      return recipe_plan(request);
    default:
      throw std::runtime_error("the study has a plan that this version of dccastd does not know");
  }
}

}  // namespace dccast::studies
