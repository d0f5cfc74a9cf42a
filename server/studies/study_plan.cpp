#include "server/studies/study_plan.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "proto/case_file/override.hpp"
#include "server/intake/case_intake.hpp"

namespace dccast::studies {

namespace {

struct Kind {
  v1::CreateStudyRequest::PlanCase plan;
  std::vector<v1::Fault> (*faults)(const v1::CreateStudyRequest&);  ///< null: it can have none
  std::unique_ptr<StudyPlan> (*make)(const v1::CreateStudyRequest&);
};

constexpr Kind kinds[] = {
    {v1::CreateStudyRequest::kRefinement, refinement_faults, refinement_plan},
    {v1::CreateStudyRequest::kSweep, sweep_faults, sweep_plan},
    {v1::CreateStudyRequest::kMould, mould_faults, mould_plan},
    {v1::CreateStudyRequest::kRecipe, recipe_faults, recipe_plan},
    {v1::CreateStudyRequest::kRemedy, remedy_faults, remedy_plan},
    {v1::CreateStudyRequest::kLevers, nullptr, levers_plan},
};

/// Null without a plan, or with one that is not known here.
const Kind* kind_of(const v1::CreateStudyRequest& request) {
  const auto found = std::ranges::find(kinds, request.plan_case(), &Kind::plan);
  return found == std::end(kinds) ? nullptr : found;
}

}  // namespace

bool by_the_case_itself(const v1::Finding& failure) {
  switch (failure.kind()) {
    case v1::Finding::SOLVE_FAILED:
    case v1::Finding::CHECK_FAILED:
    case v1::Finding::INVALID_CASE:
    case v1::Finding::SHELL_MELTED_THROUGH:
    case v1::Finding::MOTION_TOO_LARGE:
      return true;
    default:
      return false;
  }
}

PlannedRun StudyPlan::planned(int number, std::string name, const v1::Case& base,
                              std::vector<v1::CaseChange> changes) const {
  PlannedRun planned{key(number), std::move(name), base, std::move(changes)};
  case_file::apply_changes(planned.description, planned.changes);
  return planned;
}

std::vector<v1::Fault> plan_faults(const v1::CreateStudyRequest& request) {
  if (const Kind* kind = kind_of(request))
    return kind->faults ? kind->faults(request) : std::vector<v1::Fault>();
  return {intake::fault_of("plan", "", "a study needs a plan",
                           "refinement, sweep, mould, recipe, remedy, levers", "give one of them")};
}

std::unique_ptr<StudyPlan> study_plan(const v1::CreateStudyRequest& request) {
  if (const Kind* kind = kind_of(request)) return kind->make(request);
  throw std::runtime_error("the study has a plan that this version of dccastd does not know");
}

}  // namespace dccast::studies
