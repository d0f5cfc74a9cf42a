#pragma once

#include "proto/case_file/toml_walker.hpp"

namespace dccast::case_file {

/// The key set by a recipe word of a table: for `casting_speed` and "scale" the field
/// `casting_speed_factor`, for "shift" `casting_speed_shift_s`; null if the table has no such word.
const FieldDescriptor* recipe_field(const FieldDescriptor& table, std::string_view word);

/// All paths with a recipe word in the message of `path`: "schedule.casting_speed.scale, ...".
std::string recipe_paths(const Descriptor& descriptor, const std::string& path);

/// Reads "0.8", "80 % until 100 mm", "1.1 from 20 s until 60 s" as a factor over time or cast
/// length that is 1 outside. Columns of faults are counted from the first byte of `text`.
void read_scale(Walk& walk, const std::string& text, const FieldDescriptor& field, v1::Curve& curve,
                const std::string& path);

}  // namespace dccast::case_file
