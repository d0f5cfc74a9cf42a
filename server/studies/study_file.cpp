#include "server/studies/study_file.hpp"

#include <stdexcept>

#include "core/storage/file.hpp"
#include "core/storage/record_log.hpp"
#include "proto/values/digests.hpp"
#include "server/jobs/events.hpp"

namespace dccast::studies {

namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t largest_part = UINT32_MAX;  // a request is bounded where it is taken

std::string header() {
  return "DCCASTSD" + storage::little_endian(1) + storage::little_endian(0);
}

std::string take_part(std::string_view& rest) {
  const auto record = storage::short_records.first_of(rest, largest_part);
  if (!record) throw std::runtime_error("is damaged");
  rest.remove_prefix(static_cast<std::size_t>(record->size));
  return std::string(record->payload);
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
  storage::replace_file(study_file(directory, record.id),
                        header() + storage::short_records.framed(study.SerializeAsString()) +
                            storage::short_records.framed(record.request.SerializeAsString()) +
                            storage::short_records.framed(record.case_sha256));
}

StudyRecord read_study_file(const fs::path& directory, const std::string& id) {
  const fs::path path = study_file(directory, id);
  if (!fs::exists(path)) throw std::runtime_error("its file " + path.string() + " is missing");
  try {
    StudyRecord record = parse(storage::read_file(path));
    if (record.id == id) return record;
  } catch (const std::runtime_error& error) {
    throw std::runtime_error("its file " + path.string() + " " + error.what());
  }
  throw std::runtime_error("its file " + path.string() + " describes another study");
}

void remove_study_file(const fs::path& directory, const std::string& id) {
  if (fs::remove(study_file(directory, id))) storage::sync_directory(directory);
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
