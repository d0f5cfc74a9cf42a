#pragma once

#include <string>

#include "dccast/v1/study.pb.h"

namespace dccast::client::render {

/// A self-contained HTML page about a sweep: the final curl against each numeric key and against
/// pairs of such keys, with the table of all runs.
std::string sweep_page(const v1::StudyResult& result);

}  // namespace dccast::client::render
