#pragma once

#include <optional>
#include <string_view>

#include "proto/case_file/text_checks.hpp"

namespace dccast::case_file {

/// Largest depth of nested lists and inline tables, and largest number of parts of a dotted key.
/// The schema needs four. The parser needs a stack frame for each level, so the depth is checked
/// before parsing.
inline constexpr int maximum_nesting = 16;

/// The first place where keys, lists or inline tables are nested too deeply; brackets and dots in
/// strings and comments are ignored.
std::optional<TextFault> check_nesting(std::string_view text);

}  // namespace dccast::case_file
