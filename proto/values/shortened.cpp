#include "proto/values/shortened.hpp"

#include <algorithm>

namespace dccast::values {
namespace {

constexpr std::string_view ellipsis = "...";

/// The largest length up to `limit` at which no character of UTF-8 is cut.
std::size_t whole_characters(std::string_view text, std::size_t limit) {
  if (text.size() <= limit) return text.size();
  while (limit > 0 && (static_cast<unsigned char>(text[limit]) & 0xC0) == 0x80) --limit;
  return limit;
}

}  // namespace

std::string shortened(std::string_view text, std::size_t limit) {
  const std::size_t line = std::min(text.find('\n'), text.size());
  const std::size_t kept = whole_characters(text.substr(0, line), limit);
  return std::string(text.substr(0, kept)) + std::string(kept < text.size() ? ellipsis : "");
}

std::string too_long(std::string_view name, std::string_view text, std::size_t limit) {
  if (text.size() <= limit) return {};
  return std::string(name) + " has " + std::to_string(text.size()) + " bytes; at most " +
         std::to_string(limit) + " are permitted";
}

}  // namespace dccast::values
