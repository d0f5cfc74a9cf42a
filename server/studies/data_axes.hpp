#pragma once

#include <vector>

#include "dccast/v1/study.pb.h"
#include "server/intake/case_intake.hpp"

/// The axes of studies over what data and levers of a case may be: uncertainty, sensitivity,
/// calibration, recipe, levers. docs/uncertainty.md.
namespace dccast::studies {

/// Whether the plan of a request moves data of the case over their ranges.
bool has_data_axes(const v1::CreateStudyRequest& request);

/// Completes the case of a request that has_data_axes(), so that card, mesh and steps are the same
/// in all runs. A plan without axes gets all data that have a range, an axis without values the
/// range of its key. A sweep is of draft quality unless a change of the request names another; a
/// recipe has drafts besides its case; levers keep the ranges in their case, a draft.
/// @return faults of the case, or of keys without a range
std::vector<v1::Fault> lay_out_axes(const intake::CaseIntake& intake,
                                    const jobs::Attachments& attachments,
                                    v1::CreateStudyRequest& request);

}  // namespace dccast::studies
