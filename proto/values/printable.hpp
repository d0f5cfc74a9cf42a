#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace dccast::values {

enum class Lines { one, several };

/// The first character of a text that would act on a terminal or a log instead of being shown: a
/// control of C0 or C1, a mark of direction (bidi), a line or paragraph separator, a byte that is
/// no UTF-8. Names it with its place, e.g. "U+001B (ESC) at byte 5"; nothing in a text without one.
/// @param lines  several: line feeds and tabs are permitted
std::optional<std::string> unprintable(std::string_view text, Lines lines = Lines::one);

/// The first byte that belongs to no character of UTF-8; nothing in a text without one.
std::optional<std::size_t> first_broken_utf8(std::string_view text);

/// The text with each of these characters written out: \u{1B}, \x{E9} for a byte that is no UTF-8.
/// The result is UTF-8.
std::string escaped(std::string_view text, Lines lines = Lines::one);

}  // namespace dccast::values
