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

/// escaped(), for between quotation marks: '"' and '\\' have a backslash before them.
std::string escaped_in_quotes(std::string_view text);

/// Largest part of a value that a message repeats [bytes].
inline constexpr std::size_t longest_echo = 60;

/// Largest length of free text in a request, such as request_id or the reason of a cancellation
/// [bytes].
inline constexpr std::size_t longest_request_text = 200;

/// The first line of a text, at most `limit` bytes, with "..." if something was omitted. UTF-8
/// characters are never cut, so the result can be stored in a message of the interface. Every value
/// repeated in an error message is shortened here.
std::string shortened(std::string_view text, std::size_t limit = longest_echo);

/// The fault of a free text that is too long, e.g. "request_id has 5000 bytes; at most 200 are
/// permitted"; empty if it is short enough.
std::string too_long(std::string_view name, std::string_view text,
                     std::size_t limit = longest_request_text);

}  // namespace dccast::values
