#include "core/results/checkpoint_file.hpp"

#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string_view>
#include <utility>

#include "core/storage/file.hpp"
#include "core/storage/record_log.hpp"

namespace dccast::results {

static_assert(std::endian::native == std::endian::little, "the files are little-endian");
static_assert(std::numeric_limits<double>::is_iec559, "the files hold IEEE 754 doubles");

namespace {

template <class T>
void put(std::string& bytes, const T* values, std::size_t count) {
  bytes.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

template <class T>
void put(std::string& bytes, T value) {
  put(bytes, &value, 1);
}

/// Takes values off the front of a run of bytes; false where there are too few.
class Cursor {
public:
  explicit Cursor(std::string_view bytes) : left_(bytes) {}

  template <class T>
  bool take(T& value) {
    if (left_.size() < sizeof(T)) return false;
    std::memcpy(&value, left_.data(), sizeof(T));
    left_.remove_prefix(sizeof(T));
    return true;
  }

  /// @param values  std::vector or std::string, set to `count` elements
  template <class Container>
  bool take(Container& values, std::uint64_t count) {
    constexpr std::size_t size = sizeof(typename Container::value_type);
    if (count > left_.size() / size) return false;
    values.resize(count);
    if (count > 0) std::memcpy(values.data(), left_.data(), count * size);
    left_.remove_prefix(count * size);
    return true;
  }

  bool empty() const { return left_.empty(); }

private:
  std::string_view left_;
};

/// A value of alternative `type`, the index in Sections::Value.
bool take_value(Cursor& cursor, std::uint8_t type, Sections::Value& value) {
  std::uint64_t count = 0;
  if (!cursor.take(count)) return false;
  if (type == 0) return cursor.take(value.emplace<0>(), count);
  if (type == 1) return cursor.take(value.emplace<1>(), count);
  return type == 2 && cursor.take(value.emplace<2>(), count);
}

}  // namespace

std::string encode(const Sections& sections) {
  std::string bytes;
  put(bytes, static_cast<std::uint32_t>(sections.all().size()));
  for (const auto& [name, value] : sections.all()) {
    put(bytes, static_cast<std::uint32_t>(name.size()));
    bytes += name;
    put(bytes, static_cast<std::uint8_t>(value.index()));
    std::visit(
        [&](const auto& values) {
          put(bytes, static_cast<std::uint64_t>(values.size()));
          put(bytes, values.data(), values.size());
        },
        value);
  }
  return bytes;
}

std::optional<Sections> decode(std::string_view bytes) {
  Cursor cursor(bytes);
  std::uint32_t count = 0;
  if (!cursor.take(count)) return std::nullopt;
  Sections sections;
  for (std::uint32_t i = 0; i < count; ++i) {
    std::uint32_t length = 0;
    std::string name;
    std::uint8_t type = 0;
    Sections::Value value;
    if (!cursor.take(length) || !cursor.take(name, length) || !cursor.take(type) ||
        !take_value(cursor, type, value))
      return std::nullopt;
    sections.set(std::move(name), std::move(value));
  }
  return cursor.empty() ? std::optional(std::move(sections)) : std::nullopt;
}

namespace {

constexpr std::uint32_t current_version = 1;

/// The first bytes of a checkpoint; see CHECKPOINT.md.
struct Preamble {
  char magic[8] = {'D', 'C', 'C', 'K', 'P', 'T', '\r', '\n'};
  std::uint32_t version = current_version;
  std::uint32_t checksum = 0;  ///< CRC-32C of the content
  std::uint64_t size = 0;      ///< of the content, in bytes
};
static_assert(sizeof(Preamble) == 24);

bool has_magic(const Preamble& preamble) {
  return std::memcmp(preamble.magic, Preamble{}.magic, sizeof preamble.magic) == 0;
}

bool is_of_other_format(const Preamble& preamble) {
  return has_magic(preamble) && preamble.version != current_version;
}

std::string format_in_words(std::uint32_t version) {
  return "checkpoint format " + std::to_string(version) + "; this program reads format " +
         std::to_string(current_version);
}

/// What is wrong with the bytes, or "".
std::string fault_of(const Preamble& preamble, std::string_view content) {
  if (!has_magic(preamble)) return "not a checkpoint";
  if (content.size() != preamble.size) return "truncated";
  if (storage::crc32c(content.data(), content.size()) != preamble.checksum) return "checksum";
  return "";
}

}  // namespace

void write_checkpoint(const std::filesystem::path& path, const Sections& content) {
  const std::string body = encode(content);
  Preamble preamble;
  preamble.checksum = storage::crc32c(body.data(), body.size());
  preamble.size = body.size();
  std::string bytes(reinterpret_cast<const char*>(&preamble), sizeof preamble);
  storage::replace_file(path, bytes += body, storage::readable_by_all);
}

CheckpointRead read_checkpoint(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) return {std::nullopt, "missing"};
  const std::string bytes = storage::read_file(path);
  Preamble preamble;
  if (bytes.size() < sizeof preamble) return {std::nullopt, "truncated"};
  std::memcpy(&preamble, bytes.data(), sizeof preamble);
  if (is_of_other_format(preamble)) return {std::nullopt, format_in_words(preamble.version), true};
  const std::string_view body = std::string_view(bytes).substr(sizeof preamble);
  if (std::string fault = fault_of(preamble, body); !fault.empty())
    return {std::nullopt, std::move(fault)};
  auto content = decode(body);
  if (!content) return {std::nullopt, "not a checkpoint"};
  return {std::move(content), ""};
}

}  // namespace dccast::results
