#include "server/studies/study_file.hpp"

#include <stdexcept>

#include "proto/values/uuid.hpp"
#include "server/jobs/durable_file.hpp"
#include "server/jobs/events.hpp"
#include "server/jobs/record_frame.hpp"

namespace dccast::studies {

namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t largest_part = UINT32_MAX;  // a request is bounded where it is taken

std::string header() {
  return "DCCASTSD" + jobs::little_endian(1) + jobs::little_endian(0);
}

std::string take_part(std::string_view& rest) {
  const auto payload = jobs::payload_of(rest, largest_part);
  if (!payload) throw std::runtime_error("is damaged");
  rest.remove_prefix(static_cast<std::size_t>(jobs::frame_head_size) + payload->size());
  return std::string(*payload);
}

StudyRecord parse(std::string_view bytes) {
  if (!bytes.starts_with(header())) throw std::runtime_error("is not of version 1");
  bytes.remove_prefix(header().size());
  v1::Study study;
  StudyRecord record;
  if (!study.ParseFromString(take_part(bytes)) || !record.request.ParseFromString(take_part(bytes)))
    throw std::runtime_error("cannot be parsed");
  record.id = study.id();
  record.owner = study.owner();
  record.created_ms = record.changed_ms = jobs::milliseconds(study.create_time());
  record.case_sha256 = take_part(bytes);
  return record;
}

}  // namespace

fs::path study_file(const fs::path& directory, const std::string& id) {
  return directory / (id + ".bin");
}

void write_study_file(const fs::path& directory, const StudyRecord& record) {
  v1::Study study;
  study.set_id(record.id);
  study.set_owner(record.owner);
  *study.mutable_create_time() = jobs::timestamp(record.created_ms);
  jobs::replace_file(study_file(directory, record.id),
                     header() + jobs::framed(study.SerializeAsString()) +
                         jobs::framed(record.request.SerializeAsString()) +
                         jobs::framed(record.case_sha256));
  jobs::sync_directory(directory);
}

StudyRecord read_study_file(const fs::path& directory, const std::string& id) {
  const fs::path path = study_file(directory, id);
  if (!fs::exists(path)) throw std::runtime_error("its file " + path.string() + " is missing");
  try {
    StudyRecord record = parse(jobs::read_file(path));
    if (record.id == id) return record;
  } catch (const std::runtime_error& error) {
    throw std::runtime_error("its file " + path.string() + " " + error.what());
  }
  throw std::runtime_error("its file " + path.string() + " describes another study");
}

void remove_study_file(const fs::path& directory, const std::string& id) {
  if (fs::remove(study_file(directory, id))) jobs::sync_directory(directory);
}

std::set<std::string> ids_of_study_files(const fs::path& directory) {
  std::set<std::string> ids;
  if (!fs::exists(directory)) return ids;
  for (const auto& entry : fs::directory_iterator(directory)) {
    const std::string id = entry.path().stem().string();
    if (entry.path().extension() == ".bin" && values::is_uuid(id)) ids.insert(id);
  }
  return ids;
}

}  // namespace dccast::studies
