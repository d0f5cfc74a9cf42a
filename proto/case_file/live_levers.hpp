#pragma once

#include <vector>

#include "dccast/v1/case.pb.h"
#include "proto/case_file/remedies.hpp"

namespace dccast::case_file {

/// Drafts for the levers that a plant can still move while it casts, each from a time on, less and
/// more of it: casting speed, water, water of the narrow faces where the case has it, and metal
/// temperature. Steps are what a plant permits itself within a casting. All cast the length that
/// the case casts. Those that the case cannot have are left out.
/// @param description  case as submitted
/// @param from_s       time of the case
std::vector<LeverDraft> lever_drafts_from(const v1::Case& description, double from_s);

}  // namespace dccast::case_file
