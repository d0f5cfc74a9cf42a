#pragma once

#include <string>

#include "dccast/v1/job.pb.h"

namespace dccast::client::render {

using Findings = google::protobuf::RepeatedPtrField<v1::Finding>;

/// "danger", "warning" or "note".
std::string severity_text(v1::Finding::Severity severity);

/// "danger: bleed_out_at_exit at 15.00 s: The surface leaves the mould at ... [1.2 mm, limit 5 mm;
/// x 280.0 mm, y 45.0 mm; plausibility.minimum_shell]", one line.
std::string finding_line(const v1::Finding& finding);

/// "1 danger, 2 warnings" for a column; empty without findings.
std::string findings_count(const Findings& findings);

/// Whether one is a warning or a danger, which makes --strict fail.
bool more_than_notes(const Findings& findings);

/// The findings as a part of a page, the most severe first; empty without findings.
std::string findings_part(const Findings& findings);

}  // namespace dccast::client::render
