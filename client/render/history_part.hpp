#pragma once

#include <string>

#include "dccast/v1/service.pb.h"

namespace dccast::client::render {

/// Charts against time of what decides whether a casting holds: shell, sump, temperatures, heat
/// through each face, how much of the bottom stands on the block. Empty with fewer than two steps.
std::string history_part(const v1::QueryResultResponse& result);

}  // namespace dccast::client::render
