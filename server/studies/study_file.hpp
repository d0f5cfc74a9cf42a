#pragma once

#include <filesystem>
#include <set>
#include <string>

#include "server/studies/study_record.hpp"

namespace dccast::studies {

/// What the data directory says about a study beside the store, so that its row can be made again:
/// `studies/<id>.bin`. Written after the row and before the study is acknowledged, removed before
/// the row: a file without a row says that rows were lost.
///
/// Format: 8 bytes "DCCASTSD", version 1 and zero as in EVENT_LOG.md, then three frames: a
/// serialised Study with id, owner and create_time, the serialised CreateStudyRequest, case_sha256
/// in hexadecimal.
std::filesystem::path study_file(const std::filesystem::path& directory, const std::string& id);

/// Writes or replaces the file; it survives a crash of the machine once this has returned.
/// @throws std::system_error
void write_study_file(const std::filesystem::path& directory, const StudyRecord& record);

/// @throws std::runtime_error  it is missing or damaged
StudyRecord read_study_file(const std::filesystem::path& directory, const std::string& id);

/// @throws std::system_error
void remove_study_file(const std::filesystem::path& directory, const std::string& id);

/// Ids of the studies that have a file. @throws std::filesystem::filesystem_error
std::set<std::string> ids_of_study_files(const std::filesystem::path& directory);

}  // namespace dccast::studies
