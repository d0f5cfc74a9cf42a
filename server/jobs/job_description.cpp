#include "server/jobs/job_description.hpp"

#include <stdexcept>

#include "core/storage/file.hpp"
#include "core/storage/record_log.hpp"

namespace dccast::jobs {

namespace {

constexpr std::uint32_t largest_part = UINT32_MAX;  // a case is bounded where it is taken

std::string header() {
  return "DCCASTJD" + storage::little_endian(1) + storage::little_endian(0);
}

/// One byte in front, as a frame is never empty but a message may be.
std::string part(std::string_view content) {
  return storage::short_records.framed('\1' + std::string(content));
}

std::string_view take_part(std::string_view& rest) {
  const auto record = storage::short_records.first_of(rest, largest_part);
  if (!record) throw std::runtime_error("is damaged (wrong checksum)");
  rest.remove_prefix(static_cast<std::size_t>(record->size));
  return record->payload.substr(1);
}

JobDescription parse(std::string_view bytes) {
  if (!bytes.starts_with(header())) throw std::runtime_error("is not of version 1");
  bytes.remove_prefix(header().size());
  JobDescription description;
  if (!description.job.ParseFromString(std::string(take_part(bytes))))
    throw std::runtime_error("cannot be parsed");
  description.submitted_case = take_part(bytes);
  description.complete_case = take_part(bytes);
  if (!bytes.empty()) description.answer_key = take_part(bytes);
  return description;
}

}  // namespace

void write_job_description(const std::filesystem::path& folder, const JobDescription& description) {
  std::string bytes = header() + part(description.job.SerializeAsString()) +
                      part(description.submitted_case) + part(description.complete_case);
  if (!description.answer_key.empty()) bytes += part(description.answer_key);
  storage::create_durably(folder / description_file, bytes);
}

JobDescription read_job_description(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / description_file;
  if (!std::filesystem::exists(path))
    throw std::runtime_error(std::string("it has no ") + description_file +
                             ": it was submitted to an earlier version of dccastd");
  try {
    return parse(storage::read_file(path));
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(std::string("its ") + description_file + " " + error.what());
  }
}

}  // namespace dccast::jobs
