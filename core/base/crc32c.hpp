#pragma once

#include <cstddef>
#include <cstdint>

namespace dccast {

/// CRC-32C (Castagnoli polynomial 0x1EDC6F41, reflected, as in RFC 3720 section 12.1).
/// @param bytes   data to be added to the checksum
/// @param so_far  checksum of the preceding data; zero for the first piece
std::uint32_t crc32c(const void* bytes, std::size_t size, std::uint32_t so_far = 0);

}  // namespace dccast
