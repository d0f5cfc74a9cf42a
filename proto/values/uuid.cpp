#include "proto/values/uuid.hpp"

#include "proto/values/hexadecimal.hpp"

namespace dccast::values {

namespace {

constexpr bool is_dash(std::size_t i) {
  return i == 8 || i == 13 || i == 18 || i == 23;
}

/// The digit with its two upper bits replaced by those of variant 1.
char of_variant_1(char digit) {
  return "89ab"[(digit <= '9' ? digit - '0' : digit - 'a' + 10) & 3];
}

}  // namespace

std::string random_uuid() {
  std::string text = random_hexadecimal(16);
  for (const std::size_t dash : {8, 13, 18, 23}) text.insert(dash, 1, '-');
  text[14] = '4';  // version 4, RFC 4122
  text[19] = of_variant_1(text[19]);
  return text;
}

bool is_uuid(std::string_view text) {
  if (text.size() != 36) return false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool digit = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
    if (is_dash(i) ? c != '-' : !digit) return false;
  }
  return true;
}

}  // namespace dccast::values
