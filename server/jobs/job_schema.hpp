#pragma once

#include <filesystem>

#include "server/jobs/sqlite.hpp"

namespace dccast::jobs {

/// Makes the tables of the job store in an empty file. A store of an earlier version is not brought
/// up to date but built again from the folders of the jobs. @throws StoreError  also for a file of
/// another version
void require_schema(Database& database, const std::filesystem::path& path);

}  // namespace dccast::jobs
