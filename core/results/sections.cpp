#include "core/results/sections.hpp"

#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>

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

/// Reads values from the front of a string of bytes; returns false if there are too few.
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

/// Reads a value of alternative `type`, the index in Sections::Value.
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

    // Type, number of values, and the values themselves (CHECKPOINT.md).
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

    // Bytes come from a file: any count may be wrong.
    if (!cursor.take(length) || !cursor.take(name, length) || !cursor.take(type) ||
        !take_value(cursor, type, value))
      return std::nullopt;
    sections.set(std::move(name), std::move(value));
  }
  return cursor.empty() ? std::optional(std::move(sections)) : std::nullopt;
}

}  // namespace dccast::results
