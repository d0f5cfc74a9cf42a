#pragma once

#include <filesystem>

#include "server/jobs/sqlite.hpp"

namespace dccast::jobs {

/// Makes the tables of the job store, or brings those of an earlier version up to date. @throws
/// StoreError  also for a file of a later version
void bring_up_to_date(Database& database, const std::filesystem::path& path);

}  // namespace dccast::jobs
