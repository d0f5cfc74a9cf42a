#pragma once

#include "server/studies/study_plan.hpp"

/// The kinds of plans. A further kind is a file with these two functions, and its line in
/// study_plan.cpp.
namespace dccast::studies {

std::vector<v1::Fault> refinement_faults(const v1::CreateStudyRequest& request);
std::unique_ptr<StudyPlan> refinement_plan(const v1::CreateStudyRequest& request);

std::vector<v1::Fault> sweep_faults(const v1::CreateStudyRequest& request);
std::unique_ptr<StudyPlan> sweep_plan(const v1::CreateStudyRequest& request);

std::vector<v1::Fault> mould_faults(const v1::CreateStudyRequest& request);
std::unique_ptr<StudyPlan> mould_plan(const v1::CreateStudyRequest& request);

}  // namespace dccast::studies
