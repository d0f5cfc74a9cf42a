#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/storage/file_window.hpp"

namespace dccast::storage {

/// One whole record of a file.
struct Record {
  std::string_view payload;
  std::uint8_t kind = 0;  ///< 0 where the format has none
  std::int64_t size = 0;  ///< with its head [bytes]
};

/// How records stand in a file: a head, then the payload. In the head are the length of the
/// payload, a CRC-32C of all that stands behind the checksum in the record, and perhaps the
/// record's kind. Numbers are little-endian and unsigned. No payload is empty, so that zeros are no
/// record.
struct RecordFormat {
  std::size_t head_size;    ///< [bytes]
  std::size_t length_at;    ///< byte of the head
  std::size_t length_size;  ///< 4 or 8 [bytes]
  std::size_t checksum_at;  ///< byte of the head
  bool has_kind;            ///< in the last byte of the head

  /// The record of a payload.
  std::string framed(std::string_view payload, std::uint8_t kind = 0) const;

  /// The length that a head says. @param head  at least head_size bytes
  std::uint64_t length_of(std::string_view head) const;

  /// The record at the start of `bytes`, which may go on behind it.
  /// @return nothing when it is cut short, empty, longer than `largest`, or its checksum is wrong
  std::optional<Record> first_of(std::string_view bytes, std::uint64_t largest) const;

  /// The record at byte `offset` of a file, good until the window is used again.
  /// @return as first_of() @throws StorageError
  std::optional<Record> at(FileWindow& file, std::int64_t offset,
                           std::uint64_t largest = UINT64_MAX) const;
};

/// Of event logs and descriptions of jobs and studies: length (4 bytes), checksum.
inline constexpr RecordFormat short_records{
    .head_size = 8, .length_at = 0, .length_size = 4, .checksum_at = 4, .has_kind = false};

/// Of journals: checksum, length (8 bytes), kind.
inline constexpr RecordFormat long_records{
    .head_size = 13, .length_at = 4, .length_size = 8, .checksum_at = 0, .has_kind = true};

std::string little_endian(std::uint32_t number);

}  // namespace dccast::storage
