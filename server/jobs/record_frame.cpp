#include "server/jobs/record_frame.hpp"

#include "core/base/crc32c.hpp"

namespace dccast::jobs {

std::string little_endian(std::uint32_t number) {
  std::string bytes;
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(number >> shift & 0xff);
  return bytes;
}

std::uint32_t from_little_endian(const char* bytes) {
  std::uint32_t number = 0;
  for (int i = 3; i >= 0; --i) number = number << 8 | static_cast<unsigned char>(bytes[i]);
  return number;
}

std::string framed(std::string_view payload) {
  std::string record = little_endian(static_cast<std::uint32_t>(payload.size()));
  record += little_endian(crc32c(payload.data(), payload.size()));
  record += payload;
  return record;
}

std::optional<std::string_view> payload_of(std::string_view bytes, std::uint32_t largest) {
  if (bytes.size() < frame_head_size) return std::nullopt;
  const std::uint32_t length = from_little_endian(bytes.data());
  if (length == 0 || length > largest || length > bytes.size() - frame_head_size)
    return std::nullopt;
  const std::string_view payload = bytes.substr(frame_head_size, length);
  if (crc32c(payload.data(), length) != from_little_endian(bytes.data() + 4)) return std::nullopt;
  return payload;
}

}  // namespace dccast::jobs
