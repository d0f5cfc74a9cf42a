#pragma once

#include <string>

#include "dccast/v1/study.pb.h"

namespace dccast::client::render {

/// A sweep as a text table: a row a run with its values, the curl of every monitor at the end and
/// what became of it.
std::string sweep_table(const v1::StudyResult& result);

/// The same for other programs, in metres; a number is empty where there is none.
std::string sweep_csv(const v1::StudyResult& result);

/// What is to be said of a run: "failed: solve failed", "succeeded, beyond validity".
std::string run_text(const v1::StudyRun& run);

}  // namespace dccast::client::render
