#pragma once

#include <string>

#include "dccast/v1/study.pb.h"

namespace dccast::client::render {

/// A sweep as a text table: one row per run with its values, the final curl of every monitor and
/// its outcome.
std::string sweep_table(const v1::StudyResult& result);

/// The same as CSV, in metres; missing numbers are empty.
std::string sweep_csv(const v1::StudyResult& result);

/// Outcome of a run: "failed: solve failed", "succeeded, beyond validity".
std::string run_text(const v1::StudyRun& run);

}  // namespace dccast::client::render
