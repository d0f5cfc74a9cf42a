#pragma once

#include <string>

#include "dccast/v1/job.pb.h"

namespace dccast::client::render {

/// How every output marks a figure that was computed after the model had stopped being valid.
inline constexpr const char* beyond_validity = "beyond validity";

/// "x 120.0 mm, y 3.0 mm"; empty where no place is known.
/// @param place_m  coordinates in the undeformed slab
std::string place_text(const google::protobuf::RepeatedField<double>& place_m);

/// "beyond validity from 166.20 s on: motion too large: the butt slides (63.1 mm, limit 20 mm) at
/// x 120.0 mm, y 0.0 mm": when, why, by how much and where, in one line.
std::string validity_text(const v1::ValidityLoss& loss);

}  // namespace dccast::client::render
