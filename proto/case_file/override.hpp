#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/job.pb.h"
#include "proto/case_file/case_file.hpp"

/// Changes to a case beside its file: `--set mesh.rows=30`, the axes of a sweep. A value is written
/// as in the file, with the same units, checks and texts of faults. Since a shell takes quotes
/// away, they may be left out: `60 mm/min`, `[[0 s, 40 mm/min], [60 s, 60 mm/min]]`.
///
/// Two recipe words stand for what plants do with a table of the schedule as a whole:
///   `schedule.water_flow.scale = "0.8 from 50 mm until 100 mm"` sets `schedule.water_flow_factor`;
///       `from` and `until` (times or cast lengths) may be absent; outside them the factor is 1
///   `schedule.water_flow.shift = "5 s"` sets `schedule.water_flow_shift`
namespace dccast::case_file {

/// "mesh.rows=30" as a change; nothing if there is no key or no '='.
std::optional<v1::CaseChange> parse_change(std::string_view text);

/// Applies the changes in their order. A change at fault leaves its key as it was or empty. Keys
/// that name a file are refused: who calls this has no folder to read it from.
/// @return  all faults, with the path of the key as in a file; empty: all changes are made
std::vector<v1::Fault> apply_changes(v1::Case& description,
                                     const std::vector<v1::CaseChange>& changes);

/// The same for a case just read: a change also mends a fault of the file in its key. Faults go to
/// `read`, where they stand at "--set KEY, column N" (of KEY=VALUE). Files are looked for in
/// `folder`.
void apply_changes(v1::Case& description, const std::vector<v1::CaseChange>& changes,
                   ReadOutcome& read, const std::filesystem::path& folder = {});

}  // namespace dccast::case_file
