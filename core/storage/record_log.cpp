#include "core/storage/record_log.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "core/storage/storage_error.hpp"

namespace dccast::storage {

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

namespace {

/// The remains of a failed write would be overwritten by the next one; they are truncated for the
/// sake of readers of the file. If this fails too, readers find a record with a wrong checksum.
void cut_part(const File& file, std::int64_t end) {
  try {
    file.cut(end);
  } catch (const StorageError&) {
    // The error of the write, which is the cause, is already being thrown.
  }
}

}  // namespace

RecordLog::RecordLog(File file) : file_(std::move(file)), end_(file_.size()), synced_(end_) {}

std::int64_t RecordLog::end() const {
  const std::lock_guard lock(mutex_);
  return end_;
}

std::int64_t RecordLog::append(std::string_view records) {
  const std::lock_guard lock(mutex_);
  if (sync_error_ != 0)
    throw StorageError(sync_error_, file_.path().string(), "could not be synchronised");
  try {
    file_.write_at(end_, records);
  } catch (const StorageError&) {
    cut_part(file_, end_);
    throw;
  }
  return std::exchange(end_, end_ + static_cast<std::int64_t>(records.size()));
}

void RecordLog::cut(std::int64_t end) {
  const std::lock_guard lock(mutex_);
  file_.cut(end);
  end_ = end;
  if (sync_error_ != 0) write_again(synced_, end);
  synced_ = 0;
  sync_error_ = 0;
}

/// The kernel takes pages that it failed to write for written: they have to be changed once more.
void RecordLog::write_again(std::int64_t begin, std::int64_t end) const {
  constexpr std::int64_t most_at_once = 1 << 20;  // [bytes]
  while (begin < end) {
    std::string bytes(static_cast<std::size_t>(std::min(end - begin, most_at_once)), '\0');
    bytes.resize(file_.read_at(begin, bytes));
    if (bytes.empty()) return;
    file_.write_at(begin, bytes);
    begin += static_cast<std::int64_t>(bytes.size());
  }
}

bool RecordLog::in_doubt() const {
  const std::lock_guard lock(mutex_);
  return sync_error_ != 0;
}

void RecordLog::sync() {
  const std::lock_guard one_at_a_time(sync_mutex_);
  std::int64_t reached;
  {
    const std::lock_guard lock(mutex_);
    if (synced_ == end_) return;
    reached = end_;
  }
  try {
    file_.sync();
  } catch (const StorageError& error) {
    // What the kernel could not write it may have dropped: a later sync that succeeds proves
    // nothing.
    const std::lock_guard lock(mutex_);
    sync_error_ = error.code().value();
    throw;
  }
  const std::lock_guard lock(mutex_);
  synced_ = reached;
}

}  // namespace dccast::storage
