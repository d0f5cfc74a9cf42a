#include "client/html/base64.hpp"

namespace dccast::client::render {

std::string base64(const std::vector<std::uint16_t>& numbers) {
  static constexpr char digits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const std::size_t bytes = 2 * numbers.size();
  const auto byte = [&](std::size_t at) -> std::uint32_t {
    return at < bytes ? (numbers[at / 2] >> (8 * (at % 2))) & 0xff : 0;
  };
  std::string text;
  text.reserve((bytes + 2) / 3 * 4);
  for (std::size_t at = 0; at < bytes; at += 3) {
    const std::uint32_t three = byte(at) << 16 | byte(at + 1) << 8 | byte(at + 2);
    for (std::size_t digit = 0; digit < 4; ++digit)
      text += at + digit <= bytes ? digits[three >> (18 - 6 * digit) & 63] : '=';
  }
  return text;
}

}  // namespace dccast::client::render
