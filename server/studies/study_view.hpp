#pragma once

#include "server/studies/studies_state.hpp"

namespace dccast::studies {

/// A study as clients see it, with the counts of its runs, and state and progress from them.
v1::Study study_view(StudiesState& state, const StudyRecord& study);

}  // namespace dccast::studies
