#pragma once

#include "core/results/frame.hpp"
#include "dccast/v1/service.pb.h"

namespace dccast::translate {

/// @param header  of the same result file; gives the temperatures where the metal freezes
v1::Frame to_proto(const results::Frame& frame, const results::RunHeader& header);

}  // namespace dccast::translate
