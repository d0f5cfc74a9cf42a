#pragma once

#include <string>

#include "dccast/v1/case.pb.h"

namespace dccast::client::render {

/// The start of a case as an SVG file: the section through the middle of the wide face, to scale,
/// with metal, mould, zones, water line and block, beside the ramps of speed and water.
/// @param complete  case with its defaults
std::string casting_drawing(const v1::Case& complete);

}  // namespace dccast::client::render
