#include "core/base/crc32c.hpp"

#include <array>

namespace dccast {

namespace {

constexpr std::uint32_t reflected_polynomial = 0x82F63B78u;

/// Bytes taken at once. Eight tables make a checksum cheap beside the write it protects.
constexpr std::size_t slices = 8;
using Table = std::array<std::uint32_t, 256>;

/// tables()[k][b]: what byte b adds to the sum when k more bytes follow it in the slice.
constexpr std::array<Table, slices> make_tables() {
  std::array<Table, slices> tables{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t remainder = byte;
    for (int bit = 0; bit < 8; ++bit)
      remainder = (remainder >> 1) ^ ((remainder & 1u) ? reflected_polynomial : 0u);
    tables[0][byte] = remainder;
  }
  for (std::size_t k = 1; k < slices; ++k)
    for (std::size_t byte = 0; byte < 256; ++byte)
      tables[k][byte] = (tables[k - 1][byte] >> 8) ^ tables[0][tables[k - 1][byte] & 0xFFu];
  return tables;
}

constexpr auto tables = make_tables();

std::uint32_t add_slice(std::uint32_t sum, const unsigned char* at) {
  std::uint32_t next = 0;
  for (std::size_t i = 0; i < slices; ++i) {
    const std::uint32_t of_sum = i < 4 ? (sum >> (8 * i)) & 0xFFu : 0u;
    next ^= tables[slices - 1 - i][at[i] ^ of_sum];
  }
  return next;
}

}  // namespace

std::uint32_t crc32c(const void* bytes, std::size_t size, std::uint32_t so_far) {
  const auto* at = static_cast<const unsigned char*>(bytes);
  std::uint32_t sum = ~so_far;
  for (; size >= slices; size -= slices, at += slices) sum = add_slice(sum, at);
  for (; size > 0; --size, ++at) sum = (sum >> 8) ^ tables[0][(sum ^ *at) & 0xFFu];
  return ~sum;
}

}  // namespace dccast
