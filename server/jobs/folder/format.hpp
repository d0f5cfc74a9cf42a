#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

namespace dccast::jobs {

/// Format of the files of jobs, studies and lines in a data directory. The next one is due when a
/// layout or a message changes so that these files can no longer be read.
inline constexpr std::uint32_t data_format = 4;

/// The first 16 bytes of such a file: its kind, then the format twice, so that one damaged byte
/// does not make it a file of another format.
/// @param kind  8 characters, e.g. "DCCASTJD"
std::string file_header(std::string_view kind);

/// A file has another format than this program reads. The text names file, formats and remedy.
class OtherFormat : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// Checks the beginning of a file. Damaged headers pass: the checksums of the records decide.
/// @param path  of the file, or of the folder that it describes: what the message names
/// @throws OtherFormat
void require_data_format(const std::filesystem::path& path, std::string_view bytes,
                         std::string_view kind);

/// Frames a part of a file, or a message in a row, behind a byte of value 1: a part may be empty,
/// but a frame may not.
std::string framed_part(std::string_view content);

/// A framed part, and the bytes behind it.
struct Part {
  std::string_view content, rest;
};
/// The part at the start of `bytes`, a view of them. @return empty: it is damaged
std::optional<Part> first_part(std::string_view bytes);

}  // namespace dccast::jobs
