#pragma once

#include <string>

#include "dccast/v1/study.pb.h"

namespace dccast::client::render {

/// One HTML page about a sweep that opens from disk: the curl at the end against each numeric key,
/// and of two such keys against both, with the table of all runs.
std::string sweep_page(const v1::StudyResult& result);

}  // namespace dccast::client::render
