#pragma once

#include <string>

#include "dccast/v1/service.pb.h"

namespace dccast::client::render {

/// The casting recipe in plant units: a table of speed, water, metal, mould and block, and charts
/// of speed and water in this run.
std::string recipe_part(const v1::QueryResultResponse& result);

}  // namespace dccast::client::render
