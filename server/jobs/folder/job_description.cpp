#include "server/jobs/folder/job_description.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstdint>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include "core/storage/file.hpp"
#include "server/jobs/folder/format.hpp"
#include "server/jobs/folder/job_folder.hpp"

namespace dccast::jobs {

namespace {

constexpr std::size_t sha256_length = 64;  // [characters]
constexpr std::size_t name_column = sha256_length + 2;

void require_regular(const std::string& name, const std::string& kind) {
  if (kind != storage::regular_file)
    throw std::runtime_error(
        fmt::format("its {} is {}, not {}", name, kind, storage::regular_file));
}

std::string_view take_part(std::string_view& rest) {
  const auto part = first_part(rest);
  if (!part) throw std::runtime_error("is damaged (wrong checksum)");
  rest = part->rest;
  return part->content;
}

JobDescription parse_parts(std::string_view bytes) {
  JobDescription description;
  if (!description.job.ParseFromString(std::string(take_part(bytes))))
    throw std::runtime_error("cannot be parsed");

  description.submitted_case = take_part(bytes);
  description.complete_case = take_part(bytes);
  description.answer_key = take_part(bytes);

  std::istringstream digests{std::string(take_part(bytes))};
  for (std::string line; std::getline(digests, line);)
    if (line.size() > name_column)
      description.attachment_sha256[line.substr(name_column)] = line.substr(0, sha256_length);

  if (bytes.empty()) return description;
  std::istringstream files{std::string(take_part(bytes))};
  for (std::string line; std::getline(files, line);) description.files.push_back(line);
  return description;
}

JobDescription parse(std::string_view bytes) {
  // The header itself may be damaged: the checksums of the parts decide.
  bytes.remove_prefix(std::min(bytes.size(), file_header(description_kind).size()));
  const std::size_t half = bytes.size() / 2;
  try {
    return parse_parts(bytes.substr(0, half));
  } catch (const std::runtime_error&) {
    return parse_parts(bytes.substr(half));
  }
}

}  // namespace

void write_job_description(const std::filesystem::path& folder, const JobDescription& description) {
  std::string digests;
  for (const auto& [name, sha256] : description.attachment_sha256)
    digests += fmt::format("{}  {}\n", sha256, name);

  std::string files;
  for (const std::string& name : description.files) files += name + '\n';

  std::string parts;
  parts += framed_part(description.job.SerializeAsString());
  parts += framed_part(description.submitted_case);
  parts += framed_part(description.complete_case);
  parts += framed_part(description.answer_key);
  parts += framed_part(digests);
  parts += framed_part(files);
  storage::create_durably(folder / description_file, file_header(description_kind) + parts + parts);
}

JobDescription read_job_description(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / description_file;
  if (!std::filesystem::exists(path))
    throw std::runtime_error(fmt::format("it has no {}", description_file));

  const std::string bytes = storage::read_file(path);
  require_data_format(folder, bytes, description_kind);
  try {
    return parse(bytes);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(fmt::format("its {} {}", description_file, error.what()));
  }
}

void require_files(const std::filesystem::path& folder, const JobDescription& description) {
  std::vector<std::string> files = description.files;
  for (const auto& [name, sha256] : description.attachment_sha256)
    files.push_back(std::filesystem::path(attachments_folder) / name);

  for (const std::string& name : files) {
    const std::string kind = storage::kind_of_entry(folder / name);
    if (kind.empty()) throw std::runtime_error(fmt::format("its {} is missing", name));
    require_regular(name, kind);
  }
}

void require_files_to_run(const std::filesystem::path& folder, const JobDescription& description) {
  require_files(folder, description);
  for (const char* name : run_files)
    if (const std::string kind = storage::kind_of_entry(folder / name); !kind.empty())
      require_regular(name, kind);
}

bool read_complete_case(const std::filesystem::path& folder, v1::Case& to) {
  try {
    return to.ParseFromString(read_job_description(folder).complete_case);
  } catch (const std::runtime_error&) {
    return false;
  }
}

}  // namespace dccast::jobs
