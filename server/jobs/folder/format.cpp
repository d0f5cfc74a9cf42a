#include "server/jobs/folder/format.hpp"

#include <fmt/core.h>

#include "core/storage/record_format.hpp"

namespace dccast::jobs {

namespace {

std::uint32_t number_at(std::string_view bytes, std::size_t offset) {
  std::uint32_t number = 0;
  for (std::size_t i = sizeof number; i-- > 0;)
    number = number << 8 | static_cast<unsigned char>(bytes[offset + i]);
  return number;
}

}  // namespace

std::string file_header(std::string_view kind) {
  const std::string format = storage::little_endian(data_format);
  return std::string(kind) + format + format;
}

void require_data_format(const std::filesystem::path& path, std::string_view bytes,
                         std::string_view kind) {
  if (bytes.size() < kind.size() + 8 || !bytes.starts_with(kind)) return;

  const std::uint32_t found = number_at(bytes, kind.size());
  if (found == data_format || number_at(bytes, kind.size() + 4) == data_format) return;
  throw OtherFormat(
      fmt::format("{} has data format {}, and this dccastd reads format {}: move it away, start "
                  "dccastd with another data_directory, or use the dccastd that wrote it",
                  path.string(), found, data_format));
}

}  // namespace dccast::jobs
