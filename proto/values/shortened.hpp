#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace dccast::values {

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
