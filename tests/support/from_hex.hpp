#pragma once

#include <string>
#include <string_view>

namespace dccast {

/// Decodes pairs of hexadecimal digits; blanks between them are skipped.
inline std::string from_hex(std::string_view digits) {
  std::string bytes;
  int high = -1;  // first digit of a pair; -1: none yet

  for (const char digit : digits) {
    if (digit == ' ') continue;

    const int value = digit <= '9' ? digit - '0' : digit - 'a' + 10;
    if (high >= 0) bytes += static_cast<char>(16 * high + value);
    high = high >= 0 ? -1 : value;
  }
  return bytes;
}

}  // namespace dccast
