#pragma once

#include <string>

#include "dccast/v1/job.pb.h"

namespace dccast::client::render {

/// Mark of figures computed after the model had stopped being valid.
inline constexpr const char* beyond_validity = "beyond validity";

/// A value [`unit`] with three digits, as limits have; lengths in millimetres: "4.13 mm", "0.98",
/// "622 degC".
std::string figure_text(double value, const std::string& unit);

/// "x 120.0 mm, y 3.0 mm"; empty if no place is known.
/// @param place_m  coordinates in the undeformed slab [m]
std::string place_text(const google::protobuf::RepeatedField<double>& place_m);

/// "beyond validity from 166.20 s on: at t = 166.2 s the butt ... has slid 63.1 mm ...": the
/// message of the run, which says where and by how much, or what stands beside it where there is
/// none.
std::string validity_text(const v1::ValidityLoss& loss);

}  // namespace dccast::client::render
