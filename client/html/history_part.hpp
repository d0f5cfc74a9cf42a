#pragma once

#include <string>

#include "dccast/v1/service.pb.h"

namespace dccast::client::render {

/// Charts against time of the quantities that decide whether a casting succeeds: shell, sump,
/// temperatures, heat through each face, and the contact of the bottom with the block. Empty with
/// fewer than two steps.
std::string history_part(const v1::QueryResultResponse& result);

}  // namespace dccast::client::render
