#pragma once

#include "core/results/study_table.hpp"
#include "dccast/v1/study.pb.h"

namespace dccast::translate {

/// The runs of a study as a table. All monitors of a run share the instants of the first of its
/// curves that has any.
results::StudyTable to_table(const v1::StudyResult& result);

}  // namespace dccast::translate
