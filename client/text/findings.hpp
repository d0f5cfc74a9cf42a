#pragma once

#include <string>

#include "dccast/v1/job.pb.h"

namespace dccast::client {

/// Findings as messages have them.
using Findings = google::protobuf::RepeatedPtrField<v1::Finding>;

/// "danger: bleed_out_at_exit at 15.00 s: The surface leaves the mould at ... [1.2 mm, limit 5 mm;
/// x 280.0 mm, y 45.0 mm; plausibility.minimum_shell]", one line.
std::string finding_line(const v1::Finding& finding);

/// "1 danger, 2 warnings" for a column; empty without findings.
std::string findings_count(const Findings& findings);

/// Whether one is a warning or a danger, which makes --strict fail.
bool more_than_notes(const Findings& findings);

/// The findings as a part of a page, the most severe first.
std::string findings_part(const Findings& findings);

/// Mark of figures computed after the model had stopped being valid.
inline constexpr const char* beyond_validity = "beyond validity";

/// "x 120.0 mm, y 3.0 mm"; empty if no place is known.
/// @param place_m  coordinates in the undeformed slab [m]
std::string place_text(const google::protobuf::RepeatedField<double>& place_m);

/// "beyond validity from 166.20 s on: at t = 166.2 s the butt ... has slid 63.1 mm ...": the
/// message of the run with place and amount; without one its kind, value and limit, and place.
std::string validity_text(const v1::Finding& loss);

}  // namespace dccast::client
