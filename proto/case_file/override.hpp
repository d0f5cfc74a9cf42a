#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/job.pb.h"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/key_place.hpp"

/// Changes to a case in addition to its file: `--set mesh.rows=30`, the axes of a sweep. A value is
/// written as in the file, with the same units, checks and messages. Since a shell removes quotes,
/// they may be omitted: `60 mm/min`, `[[0 s, 40 mm/min], [60 s, 60 mm/min]]`.
///
/// Two recipe words change a whole table of the schedule:
///   `schedule.water_flow.scale = "0.8 from 50 mm until 100 mm"` sets `schedule.water_flow_factor`;
///       `from` and `until` (times or cast lengths) may be absent; outside them the factor is 1
///   `schedule.water_flow.shift = "5 s"` sets `schedule.water_flow_shift`
///
/// Any other quantity, number or table that the case gives can be changed relative to its value,
/// and of its alloy card where a case is read:
///   `alloy.specific_heat.scale = 0.95` multiplies it, a table as a whole
///   `schedule.casting_temperature.offset = "5 K"` adds to it
///   `alloy.melt_conductivity_factor[1] = 4` sets one point of a table
namespace dccast::case_file {

/// The change of a key to a value as written.
v1::CaseChange change_of(const std::string& key, const std::string& value);

/// Parses a change such as "mesh.rows=30"; empty if there is no key or no '='.
std::optional<v1::CaseChange> parse_change(std::string_view text);

/// Applies the changes in order. A faulty change leaves its key unchanged or empty. Keys that name
/// a file are rejected, since there is no folder from which the file could be read.
/// @return  all faults, with the path of the key as in a file; empty if all changes were applied
std::vector<v1::Fault> apply_changes(v1::Case& description,
                                     const std::vector<v1::CaseChange>& changes);

/// Applies changes to a case that was just read: a change also removes the fault that the file has
/// in its key. Faults are added to `read` with the position "--set KEY, column N" (of KEY=VALUE).
/// Files are looked up in `folder`.
void apply_changes(v1::Case& description, const std::vector<v1::CaseChange>& changes,
                   ReadOutcome& read, const std::filesystem::path& folder = {});

/// Applies changes to a case from another machine (read_elsewhere): a change that names a file is
/// refused.
void apply_changes_elsewhere(v1::Case& description, const std::vector<v1::CaseChange>& changes,
                             ReadOutcome& read);

}  // namespace dccast::case_file
