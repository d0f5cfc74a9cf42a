#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace dccast::values {

/// Whether a text is one line or may have several.
enum class Lines { one, several };

/// Finds the first character of a text that would act on a terminal or a log instead of being
/// shown: a control character (C0 or C1), a direction mark (bidi), a line or paragraph separator,
/// or a byte that is not UTF-8.
/// @param lines  several: line feeds and tabs are permitted
/// @return       its name and position, e.g. "U+001B (ESC) at byte 5"; nothing if there is none
std::optional<std::string> unprintable(std::string_view text, Lines lines = Lines::one);

/// Position of the first byte that is not UTF-8; nothing if there is none.
std::optional<std::size_t> first_broken_utf8(std::string_view text);

/// The text with each unprintable() character written as `\u{1B}`, or `\x{E9}` for a byte that is
/// not UTF-8. The result is UTF-8.
std::string escaped(std::string_view text, Lines lines = Lines::one);

/// escaped() for a text between quotation marks: '"' and '\\' are preceded by a backslash.
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

/// escaped() of shortened(): a foreign text as a message repeats it.
std::string shown(std::string_view text);

/// The fault of a free text that is too long, e.g. "request_id has 5000 bytes; at most 200 are
/// permitted"; empty if it is short enough.
std::string too_long(std::string_view name, std::string_view text,
                     std::size_t limit = longest_request_text);

}  // namespace dccast::values
