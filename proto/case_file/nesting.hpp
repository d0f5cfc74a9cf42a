#pragma once

#include <optional>
#include <string_view>

#include "proto/case_file/text_checks.hpp"

namespace dccast::case_file {

/// Parts of one dotted key, and lists or inline tables within each other, that are read. The schema
/// needs four; the parser takes a stack frame for each, so the bound must come before it.
inline constexpr int maximum_nesting = 16;

/// The first place where keys, lists or inline tables are nested more deeply; brackets and dots
/// within strings and comments do not count.
std::optional<TextFault> check_nesting(std::string_view text);

}  // namespace dccast::case_file
