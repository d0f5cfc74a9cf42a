#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "proto/case_file/source_map.hpp"

namespace dccast::case_file {

/// The reason why a text cannot be a case file, and its position.
struct TextFault {
  /// Where the text is at fault, what is wrong, and what to write instead.
  Position position;
  std::string message;
  std::string remedy;
};

/// Checks size, NUL bytes, UTF-8 and depth of nesting before the text is parsed.
std::optional<TextFault> check_text(std::string_view text);

/// End of the string that begins at byte `begin`: behind its last quote, or, if it is not closed,
/// behind the end of the line or of the text.
std::size_t string_end(std::string_view text, std::size_t begin);

/// Number of insertions, deletions, replacements and swaps of neighbours between two words.
int edit_distance(std::string_view a, std::string_view b);

/// The most similar of `known` if it differs in at most a third of the word, else empty.
std::string nearest(std::string_view word, const std::vector<std::string>& known);

/// Largest depth of nested lists and inline tables, and largest number of parts of a dotted key.
/// The schema needs four. The parser needs a stack frame for each level, so the depth is checked
/// before parsing.
inline constexpr int maximum_nesting = 16;

/// The first place where keys, lists or inline tables are nested too deeply; brackets and dots in
/// strings and comments are ignored.
std::optional<TextFault> check_nesting(std::string_view text);

}  // namespace dccast::case_file
