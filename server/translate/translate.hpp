#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/casting/case/case.hpp"
#include "core/casting/case/case_check.hpp"
#include "core/casting/simulation.hpp"
#include "core/results/column_file.hpp"
#include "core/results/frame.hpp"
#include "dccast/v1/case.pb.h"
#include "dccast/v1/job.pb.h"
#include "dccast/v1/service.pb.h"
#include "dccast/v1/study.pb.h"

namespace dccast::translate {

/// Converts a case to the core's structs.
/// @param complete     with defaults and alloy card filled in, checked against the schema; fields
///                     that are absent keep the core's default
/// @param attachments  folder of the files that the case names; the names become paths below it
casting::Case to_core(const v1::Case& complete, const std::filesystem::path& attachments);

/// Converts a table; a table without points becomes an empty curve.
Curve to_core(const v1::Curve& curve);

/// Converts the result of the core's check.
v1::ValidateCaseResponse to_proto(const casting::CheckedCase& checked);

/// All faults in one text, for a job whose case is found invalid only at the start of its run.
std::string describe(const std::vector<Fault>& faults);

/// Converts mesh, temperature and bottom, and names the fields that can be asked for.
/// @param header  of the same result file, with the temperatures at which the metal freezes
v1::Frame to_proto(const results::Frame& frame, const results::RunHeader& header);

/// Makes a frame one that is drawn: adds the skin, and replaces the displacement of the liquid,
/// which has no meaning, by the one that it is drawn with.
/// @param frame  as to_proto() makes it
void make_drawing(v1::Frame& frame);

/// Converts one field of a frame, and its instant; without a field where there is none of that
/// name.
v1::Frame field_to_proto(const results::Frame& frame, const std::string& name);

/// Adds a frame's temperature, displacement and further fields at points.
/// @param request   has at least one point; each has as many coordinates as the frame has
/// dimensions
/// @param response  gets the instant, and names and units of the fields; a field that no frame so
/// far
///                  has is without unit, its values are NaN
void add_probed(const results::Frame& frame, const v1::ProbeResultRequest& request,
                v1::ProbeResultResponse& response);

/// @param monitors    of the case, in its order: the core's reports identify them by index
/// @param errors      by monitor, see case_file::monitor_error(); of a further one not known
v1::StepReport to_proto(const results::StepReport& report,
                        const std::vector<casting::Monitor>& monitors,
                        const std::vector<std::optional<v1::RelativeError>>& errors = {});

/// Restores a report, bit by bit. @param dimension  2 in sections, 3 in quarter slabs
results::StepReport to_core(const v1::StepReport& report, int dimension);

/// @param failures  of a run, at least one; the first one is the cause
v1::Finding to_proto(const casting::RunFailures& failures);

v1::Finding to_proto(const results::ValidityLoss& loss);

v1::Finding to_proto(const results::Finding& finding);

/// The runs of a study as a file of columns (docs/studies.md).
results::ColumnFile to_table(const v1::StudyResult& result);

}  // namespace dccast::translate
