#include "server/studies/study_file.hpp"

#include <fcntl.h>

#include <algorithm>
#include <stdexcept>

#include "core/storage/file.hpp"
#include "core/storage/record_log.hpp"
#include "proto/values/digests.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/folder/format.hpp"

namespace dccast::studies {

namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t largest_part = UINT32_MAX;  // a request is bounded where it is taken

std::string header() {
  return jobs::file_header(study_file_kind);
}

std::string take_part(std::string_view& rest) {
  const auto record = storage::short_records.first_of(rest, largest_part);
  if (!record) throw std::runtime_error("is damaged");
  rest.remove_prefix(record->size);
  return std::string(record->payload);
}

constexpr int frames_of_study = 3;

/// The part of the file after the description of the study, as far as it is sound.
std::string_view runs_in(std::string_view bytes) {
  if (!bytes.starts_with(header())) return {};
  bytes.remove_prefix(header().size());
  for (int i = 0; i < frames_of_study; ++i) take_part(bytes);
  std::string_view rest = bytes;
  while (const auto record = storage::short_records.first_of(rest, largest_part))
    rest.remove_prefix(record->size);
  return bytes.substr(0, bytes.size() - rest.size());
}

/// The same for a file that may be damaged or empty.
std::string_view kept_runs(std::string_view bytes) {
  try {
    return runs_in(bytes);
  } catch (const std::runtime_error&) {
    return {};
  }
}

constexpr std::size_t size_of_numbers = 12;

std::string frame_of(const RunRecord& run) {
  return storage::short_records.framed(
      storage::little_endian(static_cast<std::uint32_t>(run.number)) +
      storage::little_endian(static_cast<std::uint32_t>(run.attempt)) +
      storage::little_endian(static_cast<std::uint32_t>(run.outcome)) +
      run.failure.SerializeAsString());
}

StudyRecord parse(std::string_view bytes) {
  if (!bytes.starts_with(header())) throw std::runtime_error("has a damaged header");
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

fs::path attachments_of_study(const fs::path& directory, const std::string& id) {
  return directory / (id + ".attachments");
}

jobs::Attachments study_attachments(const fs::path& directory, const StudyRecord& record) {
  const fs::path folder = attachments_of_study(directory, record.id);
  jobs::Attachments files;
  for (const v1::Attachment& named : record.request.attachments())
    files.push_back({.name = named.name(),
                     .sha256 = named.sha256(),
                     .bytes = named.size_bytes(),
                     .path = folder / named.name()});
  return files;
}

void write_study_attachments(const fs::path& directory, const std::string& id,
                             const jobs::Attachments& attachments) {
  if (attachments.empty()) return;
  const fs::path folder = attachments_of_study(directory, id);
  fs::remove_all(folder);  // of a creation that a crash cut short
  jobs::add_attachments(folder, attachments);
  storage::sync_directory(directory);
}

void remove_orphaned_attachments(const fs::path& directory, const std::vector<std::string>& known) {
  for (const auto& entry : fs::directory_iterator(directory)) {
    const std::string id = entry.path().stem().string();
    const bool is_orphan = entry.path().extension() == ".attachments" &&
                           std::ranges::find(known, id) == known.end() &&
                           !fs::exists(study_file(directory, id));
    if (is_orphan) fs::remove_all(entry.path());
  }
}

void write_study_file(const fs::path& directory, const StudyRecord& record) {
  v1::Study study;
  study.set_id(record.id);
  study.set_owner(record.owner);
  *study.mutable_create_time() = jobs::timestamp(record.created_ms);
  const fs::path path = study_file(directory, record.id);
  const std::string before = fs::exists(path) ? storage::read_file(path) : std::string();
  storage::replace_file(
      path, header() + storage::short_records.framed(study.SerializeAsString()) +
                storage::short_records.framed(record.request.SerializeAsString()) +
                storage::short_records.framed(record.case_sha256) + std::string(kept_runs(before)));
}

void append_runs(const fs::path& directory, const std::string& id,
                 const std::vector<RunRecord>& runs) {
  if (runs.empty()) return;
  const fs::path path = study_file(directory, id);
  const std::string bytes = storage::read_file(path);
  const std::string_view kept = runs_in(bytes);
  const auto end = kept.data() + kept.size() - bytes.data();
  std::string added;
  for (const RunRecord& run : runs) added += frame_of(run);
  const storage::File file(path, O_WRONLY);
  file.cut(end);  // what a crash cut short
  file.write_at(end, added);
  file.sync();
}

std::map<int, RunRecord> read_study_runs(const fs::path& directory, const std::string& id) {
  read_study_file(directory, id);
  const std::string bytes = storage::read_file(study_file(directory, id));
  std::map<int, RunRecord> runs;
  for (std::string_view rest = runs_in(bytes); !rest.empty();) {
    const std::string part = take_part(rest);
    if (part.size() < size_of_numbers) continue;

    RunRecord run;
    run.number = static_cast<int>(storage::number_at(part, 0));
    run.attempt = static_cast<int>(storage::number_at(part, 4));
    run.outcome = static_cast<v1::JobState>(storage::number_at(part, 8));
    run.failure.ParseFromString(part.substr(size_of_numbers));

    // A later entry of the same run replaces the earlier one.
    runs[run.number] = std::move(run);
  }
  return runs;
}

StudyRecord read_study_file(const fs::path& directory, const std::string& id) {
  const fs::path path = study_file(directory, id);
  if (!fs::exists(path)) throw std::runtime_error("its file " + path.string() + " is missing");

  const std::string bytes = storage::read_file(path);
  jobs::require_data_format(path, bytes, study_file_kind);
  try {
    StudyRecord record = parse(bytes);
    if (record.id == id) return record;
  } catch (const std::runtime_error& error) {
    throw std::runtime_error("its file " + path.string() + " " + error.what());
  }
  throw std::runtime_error("its file " + path.string() + " describes another study");
}

void remove_study_file(const fs::path& directory, const std::string& id) {
  if (fs::remove(study_file(directory, id))) storage::sync_directory(directory);
  fs::remove_all(attachments_of_study(directory, id));
}

std::set<std::string> ids_of_study_files(const fs::path& directory) {
  std::set<std::string> ids;
  if (!fs::is_directory(directory)) return ids;
  for (const auto& entry : fs::directory_iterator(directory)) {
    const std::string id = entry.path().stem().string();
    if (entry.path().extension() == ".bin" && values::is_uuid(id)) ids.insert(id);
  }
  return ids;
}

}  // namespace dccast::studies
