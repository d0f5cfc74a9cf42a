#pragma once

#include <string>

#include "dccast/v1/case.pb.h"

namespace dccast::client::render {

/// The casting of a case as a plant puts it, in one line: "slab 1320 x 570 mm of aa5182, speed 45
/// -> 55 mm/min from 60 s to 200 s (over 117 mm), water 110 -> 198 l/min/m = 25 -> 45 m3/h".
std::string casting_summary(const v1::Case& description);

}  // namespace dccast::client::render
