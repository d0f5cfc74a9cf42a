#include "server/jobs/folder/format.hpp"

#include <fmt/core.h>

#include "core/storage/record_format.hpp"

namespace dccast::jobs {

std::string file_header(std::string_view kind) {
  const std::string format = storage::little_endian(data_format);
  return std::string(kind) + format + format;
}

void require_data_format(const std::filesystem::path& path, std::string_view bytes,
                         std::string_view kind) {
  if (bytes.size() < kind.size() + 8 || !bytes.starts_with(kind)) return;

  const std::uint32_t found = storage::number_at(bytes, kind.size());
  if (found == data_format || storage::number_at(bytes, kind.size() + 4) == data_format) return;

  throw OtherFormat(
      fmt::format("{} has data format {}, and this dccastd reads format {}: move it away, start "
                  "dccastd with another data_directory, or use the dccastd that wrote it",
                  path.string(), found, data_format));
}

std::string framed_part(std::string_view content) {
  return storage::short_records.framed('\1' + std::string(content));
}

std::optional<Part> first_part(std::string_view bytes) {
  const auto record = storage::short_records.first_of(bytes, bytes.size());
  if (!record) return std::nullopt;
  return Part{record->payload.substr(1), bytes.substr(static_cast<std::size_t>(record->size))};
}

}  // namespace dccast::jobs
