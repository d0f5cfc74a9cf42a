#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/storage/file.hpp"

namespace dccast::storage {

/// CRC-32C (Castagnoli polynomial 0x1EDC6F41, reflected, as in RFC 3720 section 12.1).
/// @param bytes   data to be added to the checksum
/// @param so_far  checksum of the preceding data; zero for the first piece
std::uint32_t crc32c(const void* bytes, std::size_t size, std::uint32_t so_far = 0);

/// One complete record of a file.
struct Record {
  /// Content of the record, a view of the bytes it was read from.
  std::string_view payload;
  std::uint8_t kind = 0;  ///< 0 if the format has none
  std::int64_t size = 0;  ///< [bytes] including its head
};

/// Format of the records in a file: a head, then the payload. The head has the length of the
/// payload, a CRC-32C of everything after the checksum in the record, and in some formats the kind
/// of the record. Numbers are little-endian and unsigned. Payloads are never empty, so that zeros
/// are not a record.
struct RecordFormat {
  std::size_t head_size;    ///< [bytes]
  std::size_t length_at;    ///< offset in the head [bytes]
  std::size_t length_size;  ///< 4 or 8 [bytes]
  std::size_t checksum_at;  ///< offset in the head [bytes]
  bool has_kind;            ///< the last byte of the head is the kind

  /// Builds the record of a payload.
  std::string framed(std::string_view payload, std::uint8_t kind = 0) const;

  /// The payload length given in a head. @param head  at least head_size bytes
  std::uint64_t length_of(std::string_view head) const;

  /// The record at the start of `bytes`; more bytes may follow it.
  /// @return empty if the record is truncated, empty, longer than `largest`, or has a wrong
  ///         checksum
  std::optional<Record> first_of(std::string_view bytes, std::uint64_t largest) const;

  /// The record at byte `offset` of a file, valid until the window is used again.
  /// @return as first_of()
  /// @throws StorageError
  std::optional<Record> at(FileWindow& file, std::int64_t offset,
                           std::uint64_t largest = UINT64_MAX) const;
};

/// Format of event logs and of descriptions of jobs and studies: length (4 bytes), checksum.
inline constexpr RecordFormat short_records{
    .head_size = 8, .length_at = 0, .length_size = 4, .checksum_at = 4, .has_kind = false};

/// Format of journals: checksum, length (8 bytes), kind.
inline constexpr RecordFormat long_records{
    .head_size = 13, .length_at = 4, .length_size = 8, .checksum_at = 0, .has_kind = true};

/// The four bytes of a number in a file.
std::string little_endian(std::uint32_t number);
/// The number whose four bytes begin at `offset`.
std::uint32_t number_at(std::string_view bytes, std::size_t offset);

}  // namespace dccast::storage
