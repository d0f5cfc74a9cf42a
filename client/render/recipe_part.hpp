#pragma once

#include <string>

#include "dccast/v1/service.pb.h"

namespace dccast::client::render {

/// What the pit sets, in its units: a table of speed, water, metal, mould and block, and charts of
/// speed and water as this run had them.
std::string recipe_part(const v1::QueryResultResponse& result);

}  // namespace dccast::client::render
