#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace dccast::values {

/// Most bytes of a value that a message repeats.
inline constexpr std::size_t longest_echo = 60;

/// Most bytes of free text in a request: request_id, reason of a cancel.
inline constexpr std::size_t longest_request_text = 200;

/// The first line of a text, at most `limit` bytes of it, with "..." where something was left out.
/// A character of UTF-8 is never cut, so the result can be stored in a message of the contract.
/// Every value that an error repeats passes through here.
std::string shortened(std::string_view text, std::size_t limit = longest_echo);

/// What is wrong with a free text of a request, e.g. "request_id has 5000 bytes; at most 200 are
/// permitted"; empty when it is short enough.
std::string too_long(std::string_view name, std::string_view text,
                     std::size_t limit = longest_request_text);

}  // namespace dccast::values
