#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace dccast::jobs {

/// How event logs and job descriptions frame what they hold: length and CRC-32C of the payload, 4
/// bytes each, little-endian and unsigned, then the payload.
inline constexpr std::int64_t frame_head_size = 8;  // [bytes]

std::string little_endian(std::uint32_t number);
std::uint32_t from_little_endian(const char* bytes);

/// The payload with its head in front.
std::string framed(std::string_view payload);

/// The payload of the frame at the start of `bytes`, which may go on behind it.
/// @return nothing when it is cut short, longer than `largest`, empty, or its checksum is wrong
std::optional<std::string_view> payload_of(std::string_view bytes, std::uint32_t largest);

}  // namespace dccast::jobs
