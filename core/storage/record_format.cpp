#include "core/storage/record_format.hpp"

#include <array>
#include <string>

namespace dccast::storage {

namespace {

constexpr std::uint32_t reflected_polynomial = 0x82F63B78u;

/// Bytes per table lookup (slicing-by-8): a checksum is cheap compared with the write it protects.
constexpr std::size_t slices = 8;
using Table = std::array<std::uint32_t, 256>;

/// tables[k][b] is the contribution of byte b to the sum if k more bytes follow it in the slice.
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

/// Adds eight bytes to a sum.
std::uint32_t add_slice(std::uint32_t sum, const unsigned char* bytes) {
  std::uint32_t next = 0;
  for (std::size_t i = 0; i < slices; ++i) {
    const std::uint32_t sum_byte = i < 4 ? (sum >> (8 * i)) & 0xFFu : 0u;
    next ^= tables[slices - 1 - i][bytes[i] ^ sum_byte];
  }
  return next;
}

constexpr std::size_t checksum_size = 4;  // [bytes]

/// Writes a little-endian number of `size` bytes at an offset of a head.
void write_number(std::string& head, std::size_t offset, std::size_t size, std::uint64_t number) {
  for (std::size_t i = 0; i < size; ++i)
    head[offset + i] = static_cast<char>(number >> 8 * i & 0xff);
}

/// Reads a little-endian number of `size` bytes at an offset.
std::uint64_t read_number(std::string_view bytes, std::size_t offset, std::size_t size) {
  std::uint64_t number = 0;
  for (std::size_t i = size; i-- > 0;)
    number = number << 8 | static_cast<unsigned char>(bytes[offset + i]);
  return number;
}

/// Checksum of everything behind it in the record. @param head  of the record
std::uint32_t compute_checksum(const RecordFormat& format, std::string_view head,
                               std::string_view payload) {
  const std::string_view rest = head.substr(format.checksum_at + checksum_size);
  return crc32c(payload.data(), payload.size(), crc32c(rest.data(), rest.size()));
}

}  // namespace

std::uint32_t crc32c(const void* bytes, std::size_t size, std::uint32_t so_far) {
  const auto* next = static_cast<const unsigned char*>(bytes);
  const auto* end = next + size;
  std::uint32_t sum = ~so_far;

  for (; static_cast<std::size_t>(end - next) >= slices; next += slices) sum = add_slice(sum, next);
  for (; next != end; ++next) sum = (sum >> 8) ^ tables[0][(sum ^ *next) & 0xFFu];
  return ~sum;
}

std::string little_endian(std::uint32_t number) {
  std::string bytes(sizeof number, '\0');
  write_number(bytes, 0, sizeof number, number);
  return bytes;
}

std::uint32_t number_at(std::string_view bytes, std::size_t offset) {
  return static_cast<std::uint32_t>(read_number(bytes, offset, sizeof(std::uint32_t)));
}

std::string RecordFormat::framed(std::string_view payload, std::uint8_t kind) const {
  std::string record(head_size, '\0');
  write_number(record, length_at, length_size, payload.size());
  if (has_kind) record.back() = static_cast<char>(kind);
  write_number(record, checksum_at, checksum_size, compute_checksum(*this, record, payload));
  return record += payload;
}

std::uint64_t RecordFormat::length_of(std::string_view head) const {
  return read_number(head, length_at, length_size);
}

std::optional<Record> RecordFormat::first_of(std::string_view bytes, std::uint64_t largest) const {
  if (bytes.size() < head_size) return std::nullopt;
  const std::string_view head = bytes.substr(0, head_size);
  const std::uint64_t length = length_of(head);
  if (length == 0 || length > largest || length > bytes.size() - head_size) return std::nullopt;

  const std::string_view payload = bytes.substr(head_size, length);
  if (compute_checksum(*this, head, payload) != read_number(head, checksum_at, checksum_size))
    return std::nullopt;

  return Record{.payload = payload,
                .kind = has_kind ? static_cast<std::uint8_t>(head.back()) : std::uint8_t{0},
                .size = static_cast<std::int64_t>(head_size + length)};
}

std::optional<Record> RecordFormat::at(FileWindow& file, std::int64_t offset,
                                       std::uint64_t largest) const {
  const std::string_view head = file.at(offset, static_cast<std::int64_t>(head_size));
  if (head.size() < head_size) return std::nullopt;

  // A damaged length must not make this allocate memory for it.
  const std::uint64_t length = length_of(head);
  const std::uint64_t available = static_cast<std::uint64_t>(file.size() - offset) - head_size;
  if (length > largest || length > available) return std::nullopt;
  return first_of(file.at(offset, static_cast<std::int64_t>(head_size + length)), largest);
}

}  // namespace dccast::storage
