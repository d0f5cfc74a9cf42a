#include "server/state/wal_file.hpp"

#include <cstdint>
#include <string_view>

#include "core/storage/file.hpp"

namespace dccast::state {

namespace {

constexpr std::size_t header_size = 32;        // [bytes]
constexpr std::size_t frame_header_size = 24;  // [bytes]
constexpr std::uint32_t magic = 0x377f0682;    // its last bit: checksums of big-endian words
constexpr std::uint32_t version = 3007000;

std::uint32_t big_endian(std::string_view bytes, std::size_t at) {
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < 4; ++i)
    number = number << 8 | static_cast<unsigned char>(bytes[at + i]);
  return number;
}

std::uint32_t byte_swapped(std::uint32_t number) {
  return __builtin_bswap32(number);
}

/// The running checksum of a WAL.
struct Checksum {
  bool big_endian_words = false;
  std::uint32_t first = 0;
  std::uint32_t second = 0;

  void add(std::string_view bytes) {
    for (std::size_t at = 0; at + 8 <= bytes.size(); at += 8) {
      first += word(bytes, at) + second;
      second += word(bytes, at + 4) + first;
    }
  }
  bool stands_at(std::string_view bytes, std::size_t at) const {
    return first == big_endian(bytes, at) && second == big_endian(bytes, at + 4);
  }

private:
  std::uint32_t word(std::string_view bytes, std::size_t at) const {
    const std::uint32_t number = big_endian(bytes, at);
    return big_endian_words ? number : byte_swapped(number);
  }
};

/// Frames of this generation carry the salts of the header; those of earlier ones have others.
bool same_salts(std::string_view frame, std::string_view header) {
  return frame.substr(8, 8) == header.substr(16, 8);
}

/// Whether one of these frames belongs to the generation of the header.
bool any_of_generation(std::string_view frames, std::size_t frame_size, std::string_view header) {
  for (; frames.size() >= frame_size; frames.remove_prefix(frame_size))
    if (same_salts(frames, header)) return true;
  return false;
}

}  // namespace

WalState inspect_wal(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) return WalState::empty;
  const std::string content = storage::read_file(path);
  if (content.size() <= header_size) return WalState::empty;
  const std::string_view header = std::string_view(content).substr(0, header_size);
  Checksum checksum{.big_endian_words = (big_endian(header, 0) & 1) != 0};
  checksum.add(header.substr(0, 24));
  if ((big_endian(header, 0) & ~1u) != magic || big_endian(header, 4) != version ||
      !checksum.stands_at(header, 24))
    return WalState::damaged_header;
  const std::size_t frame_size = frame_header_size + big_endian(header, 8);
  std::string_view frames = std::string_view(content).substr(header_size);
  for (; frames.size() >= frame_size; frames.remove_prefix(frame_size)) {
    checksum.add(frames.substr(0, 8));
    checksum.add(frames.substr(frame_header_size, frame_size - frame_header_size));
    if (same_salts(frames, header) && checksum.stands_at(frames, 16)) continue;
    frames.remove_prefix(frame_size);
    return any_of_generation(frames, frame_size, header) ? WalState::damaged_frames
                                                         : WalState::sound;
  }
  return WalState::sound;
}

}  // namespace dccast::state
