#include "core/base/crc32c.hpp"

#include <array>

namespace dccast {

namespace {

constexpr std::uint32_t reflected_polynomial = 0x82F63B78u;

constexpr std::array<std::uint32_t, 256> byte_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t remainder = byte;
    for (int bit = 0; bit < 8; ++bit)
      remainder = (remainder >> 1) ^ ((remainder & 1u) ? reflected_polynomial : 0u);
    table[byte] = remainder;
  }
  return table;
}

constexpr auto table = byte_table();

}  // namespace

std::uint32_t crc32c(const void* bytes, std::size_t size, std::uint32_t so_far) {
  const auto* at = static_cast<const unsigned char*>(bytes);
  std::uint32_t sum = ~so_far;
  for (std::size_t i = 0; i < size; ++i) sum = (sum >> 8) ^ table[(sum ^ at[i]) & 0xFFu];
  return ~sum;
}

}  // namespace dccast
