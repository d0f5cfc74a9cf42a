#pragma once

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <string>
#include <string_view>

#include "core/storage/file.hpp"

/// What the programs of this folder have in common. Each has one function, which libFuzzer calls
/// with one text after another: tests/fuzz/README.md.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size);

namespace dccast::fuzz {

/// Ends the program: a reader has taken a text for what it is not.
inline void require(bool holds, const char* what) {
  if (holds) return;
  std::cerr << "broken promise: " << what << std::endl;
  std::abort();
}

inline std::string_view text_of(const std::uint8_t* bytes, std::size_t size) {
  return {reinterpret_cast<const char*>(bytes), size};
}

/// The first byte, which chooses what the others are; they are left.
inline unsigned take_choice(std::string_view& text) {
  if (text.empty()) return 0;
  const auto choice = static_cast<unsigned char>(text.front());
  text.remove_prefix(1);
  return choice;
}

/// A folder of this process, which tests/fuzz/run puts into memory and removes (TMPDIR).
inline const std::filesystem::path& folder() {
  static const auto path =
      std::filesystem::temp_directory_path() / ("dccast-fuzz-" + std::to_string(::getpid()));
  static const bool made = std::filesystem::create_directories(path);
  require(made || std::filesystem::exists(path), "there is a folder for texts");
  return path;
}

/// A file with a text, for readers that take a path.
inline const std::filesystem::path& file_with(std::string_view text) {
  static const auto path = folder() / "text";
  storage::write_file(path, text);
  return path;
}

}  // namespace dccast::fuzz
