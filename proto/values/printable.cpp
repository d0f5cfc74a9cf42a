#include "proto/values/printable.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

namespace dccast::values {
namespace {

/// One character of a text, or one byte that is not the beginning of one.
struct Character {
  std::uint32_t code = 0;
  std::size_t bytes = 1;
  bool is_utf8 = true;
};

/// Decodes the first character of a text. @param text  not empty
Character decode_first(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return {first};

  const Character broken{first, 1, false};
  const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4 || text.size() < length) return broken;

  std::uint32_t code = first & (0x7Fu >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return broken;
    code = code << 6 | (byte(i) & 0x3Fu);
  }

  // Refuse overlong forms, surrogates, and codes beyond the last character (RFC 3629).
  constexpr std::array<std::uint32_t, 5> smallest{0, 0, 0x80, 0x800, 0x10000};
  if (code < smallest[length] || (code >= 0xD800 && code <= 0xDFFF) || code > 0x10FFFF)
    return broken;
  return {code, length};
}

bool is_printable(const Character& c, Lines lines) {
  if (!c.is_utf8) return false;
  if (lines == Lines::several && (c.code == '\n' || c.code == '\t')) return true;
  const auto within = [&](std::uint32_t first, std::uint32_t last) {
    return c.code >= first && c.code <= last;
  };

  const bool control = c.code < 0x20 || within(0x7F, 0x9F);
  // U+2028 and U+2029 end lines; the others change the direction of what follows.
  const bool layout = c.code == 0x061C || within(0x200E, 0x200F) || within(0x2028, 0x202E) ||
                      within(0x2066, 0x2069) || c.code == 0xFEFF;
  return !control && !layout;
}

/// Name of a character for a message, e.g. "U+001B (ESC)".
std::string describe(const Character& c) {
  if (!c.is_utf8) return fmt::format("the byte 0x{:02X}, which is no UTF-8,", c.code);
  static constexpr std::array names{
      std::pair{0x00u, "NUL"},       std::pair{0x09u, "tab"},
      std::pair{0x0Au, "line feed"}, std::pair{0x0Du, "carriage return"},
      std::pair{0x1Bu, "ESC"},       std::pair{0x7Fu, "DEL"},
      std::pair{0x9Bu, "CSI"},       std::pair{0x9Du, "OSC"}};
  for (const auto& [code, name] : names)
    if (code == c.code) return fmt::format("U+{:04X} ({})", code, name);
  return fmt::format("U+{:04X}", c.code);
}

}  // namespace

std::optional<std::string> unprintable(std::string_view text, Lines lines) {
  for (std::size_t offset = 0; offset < text.size();) {
    const Character c = decode_first(text.substr(offset));
    if (!is_printable(c, lines)) return fmt::format("{} at byte {}", describe(c), offset + 1);
    offset += c.bytes;
  }
  return std::nullopt;
}

std::optional<std::size_t> first_broken_utf8(std::string_view text) {
  for (std::size_t offset = 0; offset < text.size();) {
    const Character c = decode_first(text.substr(offset));
    if (!c.is_utf8) return offset;
    offset += c.bytes;
  }
  return std::nullopt;
}

std::string escaped(std::string_view text, Lines lines) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const Character c = decode_first(text);
    if (is_printable(c, lines))
      result.append(text.substr(0, c.bytes));
    else
      result +=
          c.is_utf8 ? fmt::format("\\u{{{:X}}}", c.code) : fmt::format("\\x{{{:02X}}}", c.code);
    text.remove_prefix(c.bytes);
  }
  return result;
}

std::string escaped_in_quotes(std::string_view text) {
  std::string quotable;
  for (const char c : escaped(text)) {
    if (c == '"' || c == '\\') quotable += '\\';
    quotable += c;
  }
  return quotable;
}

std::string shortened(std::string_view text, std::size_t limit) {
  const std::string_view line = text.substr(0, text.find('\n'));
  std::size_t kept = std::min(line.size(), limit);

  // Do not cut a character of UTF-8.
  while (kept > 0 && kept < line.size() && (static_cast<unsigned char>(line[kept]) & 0xC0) == 0x80)
    --kept;

  return fmt::format("{}{}", line.substr(0, kept), kept < text.size() ? "..." : "");
}

std::string shown(std::string_view text) {
  return escaped(shortened(text));
}

std::string too_long(std::string_view name, std::string_view text, std::size_t limit) {
  if (text.size() <= limit) return {};
  return fmt::format("{} has {} bytes; at most {} are permitted", name, text.size(), limit);
}

}  // namespace dccast::values
