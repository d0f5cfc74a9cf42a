#pragma once

#include "client/model/json.hpp"
#include "dccast/v1/judgement.pb.h"

namespace dccast::client {

/// A judgement for programs: its sentences; its tables by their keys, each a list of rows whose
/// members are named by column and unit ("difference_m", "difference_error_m"); its charts. Figures
/// are in SI. A figure that is not known is left out.
Json judgement_json(const v1::Judgement& judgement);

/// The figures of a study, as EvaluateStudy has them, and beside them its judgement.
Json study_json(const v1::StudyJudgement& answer);

}  // namespace dccast::client
