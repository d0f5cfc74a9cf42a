#pragma once

#include <string>

#include "dccast/v1/study.pb.h"

namespace dccast::client::render {

/// A self-contained HTML page about recipes: what came out, the curl of each with its band, their
/// ramps, and the table shown in the terminal.
std::string recipe_page(const v1::StudyResult& result);

}  // namespace dccast::client::render
