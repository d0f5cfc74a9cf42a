#include "core/storage/record_format.hpp"

#include "core/base/crc32c.hpp"

namespace dccast::storage {

namespace {

constexpr std::size_t checksum_size = 4;  // [bytes]

void put(std::string& head, std::size_t at, std::size_t size, std::uint64_t number) {
  for (std::size_t i = 0; i < size; ++i) head[at + i] = static_cast<char>(number >> 8 * i & 0xff);
}

std::uint64_t number_at(std::string_view bytes, std::size_t at, std::size_t size) {
  std::uint64_t number = 0;
  for (std::size_t i = size; i-- > 0;)
    number = number << 8 | static_cast<unsigned char>(bytes[at + i]);
  return number;
}

/// Of what stands in a record behind its checksum. @param head  of the record
std::uint32_t checksum_of(const RecordFormat& format, std::string_view head,
                          std::string_view payload) {
  const std::string_view rest = head.substr(format.checksum_at + checksum_size);
  return crc32c(payload.data(), payload.size(), crc32c(rest.data(), rest.size()));
}

}  // namespace

std::string little_endian(std::uint32_t number) {
  std::string bytes(sizeof number, '\0');
  put(bytes, 0, sizeof number, number);
  return bytes;
}

std::string RecordFormat::framed(std::string_view payload, std::uint8_t kind) const {
  std::string record(head_size, '\0');
  put(record, length_at, length_size, payload.size());
  if (has_kind) record.back() = static_cast<char>(kind);
  put(record, checksum_at, checksum_size, checksum_of(*this, record, payload));
  return record += payload;
}

std::uint64_t RecordFormat::length_of(std::string_view head) const {
  return number_at(head, length_at, length_size);
}

std::optional<Record> RecordFormat::first_of(std::string_view bytes, std::uint64_t largest) const {
  if (bytes.size() < head_size) return std::nullopt;
  const std::string_view head = bytes.substr(0, head_size);
  const std::uint64_t length = length_of(head);
  if (length == 0 || length > largest || length > bytes.size() - head_size) return std::nullopt;
  const std::string_view payload = bytes.substr(head_size, length);
  if (checksum_of(*this, head, payload) != number_at(head, checksum_at, checksum_size))
    return std::nullopt;
  return Record{.payload = payload,
                .kind = has_kind ? static_cast<std::uint8_t>(head.back()) : std::uint8_t{0},
                .size = static_cast<std::int64_t>(head_size + length)};
}

std::optional<Record> RecordFormat::at(FileWindow& file, std::int64_t offset,
                                       std::uint64_t largest) const {
  const std::string_view head = file.at(offset, static_cast<std::int64_t>(head_size));
  if (head.size() < head_size) return std::nullopt;
  const std::uint64_t length = length_of(head);
  const std::uint64_t left = static_cast<std::uint64_t>(file.size() - offset) - head_size;
  if (length > largest || length > left) return std::nullopt;  // before memory is taken for it
  return first_of(file.at(offset, static_cast<std::int64_t>(head_size + length)), largest);
}

}  // namespace dccast::storage
